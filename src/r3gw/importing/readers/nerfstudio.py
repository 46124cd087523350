"""Reader of nerfstudio folders: photos and transforms.json (docs.nerf.studio, "Data conventions").

Its cameras look along -z with y up (OpenGL), and its world has z up; intrinsics are those of
COLMAP (pixel centres at +0.5).
"""

from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.files.names import stated
from r3gw.imaging.files import LDR_SUFFIXES
from r3gw.importing.evaluation_config import read_evaluation
from r3gw.importing.folders import (
    masks_beside,
    masks_of,
    notes_on_masks,
    require_training_views,
    session_of,
    split_beside,
)
from r3gw.importing.named_files import listed, pictures_below
from r3gw.importing.posed import camera_of, pose_from_matrix
from r3gw.importing.reader import Effort, Reader
from r3gw.importing.readers.ply_points import read_ply_points
from r3gw.importing.readers.transforms import (
    Frame,
    Transforms,
    lens_of,
    named_files,
    read_transforms,
    split_names,
    unread_keys,
)
from r3gw.importing.reconstruction.triangulate import triangulated_points
from r3gw.importing.settings import NerfstudioScene
from r3gw.importing.source import SourceMask, SourceScene, SourceView
from r3gw.importing.split import Split
from r3gw.scene.names import ByPhoto, key_of, normalised

# scene (up -y) from nerfstudio's world (up z); the same turn that its COLMAP import takes back.
UPRIGHT_FROM_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
_OPENCV_SIGNS = np.array([1.0, -1.0, -1.0, 1.0])  # of a pose's columns, from OpenGL's axes


class NerfstudioReader(Reader[NerfstudioScene]):
    """transforms.json with its photos, masks and points; points are triangulated if absent."""

    @property
    def _file(self) -> Path:
        return self.source / "transforms.json"

    def missing(self, given: Collection[str] = ()) -> list[str]:  # noqa: ARG002
        """Photos, masks and the point cloud that the file names."""
        if not self._file.is_file():
            return ["transforms.json"]
        transforms = read_transforms(self._file)
        photos = [frame.file_path for frame in transforms.frames]
        missing = [name for name in photos if not _photo_of(self.source, name).is_file()]
        named = named_files(transforms)
        missing += [
            name for name in named if not stated(self.source, name, str(self._file)).is_file()
        ]
        return missing + self.missing_evaluation()

    def read(self, effort: Effort) -> SourceScene:
        """The photos of all frames that are in a split."""
        transforms = read_transforms(self._file)
        frames = self._frames(transforms)
        splits = self._splits(transforms, list(frames))
        beside = masks_beside(self.source, list(frames))
        evaluation = ByPhoto(
            read_evaluation(self.source / "eval_files"), list(frames), "test_config.py"
        )
        views = []
        for path, (frame, photo) in frames.items():
            if path not in splits:
                continue
            masks = masks_of(beside, path)
            if frame.mask_path is not None:
                masks["is_valid"] = SourceMask(
                    stated(self.source, frame.mask_path, str(self._file))
                )
            lens = lens_of(frame, transforms, photo, self._file)
            views.append(
                SourceView(
                    path=path,
                    photo=photo,
                    camera=camera_of(_pose(frame, photo), lens, str(photo)),
                    split=splits[path],
                    session=session_of(path),
                    masks=masks,
                    evaluation=evaluation.get(path),
                    lens=None if lens.is_pinhole else lens,
                )
            )
        require_training_views((view.split for view in views), self._file)
        ordered = tuple(sorted(views, key=lambda view: view.path))
        if transforms.ply_file_path is not None:
            points = read_ply_points(stated(self.source, transforms.ply_file_path, str(self._file)))
        else:
            points = triangulated_points(ordered, self.source, effort)
        unread = unread_keys(transforms)
        note = f"keys of transforms.json that r3gw does not know: {listed(unread)}"
        return SourceScene(
            ordered,
            points,
            turn=UPRIGHT_FROM_Z_UP if self.settings.up == "given" else None,
            left_out=self._left_out(frames, splits),
            notes=(*((note,) if unread else ()), *notes_on_masks(beside)),
        )

    def _frames(self, transforms: Transforms) -> dict[str, tuple[Frame, Path]]:
        """Every frame and its photo, by the photo's path below the scene's folder."""
        frames: dict[str, tuple[Frame, Path]] = {}
        keys: dict[str, Path] = {}
        for frame in transforms.frames:
            photo = _photo_of(self.source, frame.file_path)
            path = normalised(_below(photo, self.source))
            if (other := keys.setdefault(key_of(path), photo)) != photo or path in frames:
                raise InputError(
                    f"{photo}: has the same stem as {other.name} in the same folder, or is in "
                    "transforms.json twice; rename or remove one of the two"
                )
            frames[path] = frame, photo
        return frames

    def _splits(self, transforms: Transforms, photos: list[str]) -> Mapping[str, Split]:
        """The file's own lists, else a ``*_split.csv``, else all for training."""
        names = split_names(transforms)
        if names is None:
            return split_beside(self.source, photos)
        splits: dict[str, Split] = {}
        for split in ("train", "test"):
            listed_ones = ByPhoto(
                {normalised(name): name for name in names[split]}, photos, str(self._file)
            )
            splits |= {photo: split for photo in photos if photo in listed_ones}
        return splits

    def _left_out(
        self, frames: Mapping[str, tuple[Frame, Path]], splits: Mapping[str, Split]
    ) -> dict[str, str]:
        """Frames outside the split, and pictures in the photos' folders that no frame names."""
        reasons = {path: "in neither list of the split" for path in frames if path not in splits}
        used = {photo.resolve() for _, photo in frames.values()}
        for folder in sorted({photo.parent for _, photo in frames.values()}):
            for file in pictures_below(folder).values() if folder != self.source else ():
                if file.parent == folder and file.resolve() not in used:
                    reasons[normalised(_below(file, self.source))] = "not in transforms.json"
        return reasons


def _photo_of(source: Path, file_path: str) -> Path:
    """The photo that a frame names; its suffix may be left out. It need not exist.

    Raises:
        InputError: If the name leads out of the scene's folder.
    """
    endings = ("", *LDR_SUFFIXES, *(suffix.upper() for suffix in LDR_SUFFIXES))
    file = str(source / "transforms.json")
    candidates = [stated(source, file_path + ending, file) for ending in endings]
    return next((path for path in candidates if path.is_file()), candidates[0])


def _below(path: Path, folder: Path) -> str:
    """A path relative to a folder, or, of a file elsewhere, as it is but for its root."""
    if path.is_relative_to(folder):
        return path.relative_to(folder).as_posix()
    return path.as_posix().lstrip("/").replace("../", "")


def _pose(frame: Frame, photo: Path) -> NDArray[np.float64]:
    rows = frame.transform_matrix
    if len(rows) not in (3, 4) or any(len(row) != 4 for row in rows):
        raise InputError(f"{photo}: 'transform_matrix' is not 4x4; correct transforms.json")
    last = rows[3] if len(rows) == 4 else [0.0, 0.0, 0.0, 1.0]
    world_from_opengl = np.array([*rows[:3], last])
    return pose_from_matrix(world_from_opengl * _OPENCV_SIGNS, str(photo))
