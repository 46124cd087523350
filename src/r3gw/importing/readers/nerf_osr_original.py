"""Reader of NeRF-OSR scenes as their authors published them: ``final/{train,test}/…``.

Poses and intrinsics are text files with 16 numbers, row by row, in the format of NeRF++
(github.com/Kai-46/nerfplusplus, README, "Data"): the pose is world_from_camera with OpenCV axes.
There is no sparse model, so the initial points are triangulated.
"""

from collections.abc import Collection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.importing.evaluation_config import read_evaluation
from r3gw.importing.folders import mask_files, require_training_views, session_of
from r3gw.importing.lens import Lens
from r3gw.importing.named_files import files_below, pictures_below
from r3gw.importing.posed import camera_of, picture_size, pose_from_matrix
from r3gw.importing.reader import Effort, Reader
from r3gw.importing.reconstruction.triangulate import triangulated_points
from r3gw.importing.settings import NerfOsrOriginalScene
from r3gw.importing.source import SourceScene, SourceView
from r3gw.importing.split import Split
from r3gw.scene.names import ByPhoto, key_of, stem_of

SPLITS: tuple[Split, ...] = ("train", "test")
MATRICES = ("pose", "intrinsics")


class NerfOsrOriginalReader(Reader[NerfOsrOriginalScene]):
    """``final/{train,test}/{rgb,pose,intrinsics,mask,cityscapes_mask}`` and ``eval_files/``."""

    @property
    def _final(self) -> Path:
        """``source/final`` if there is one, else ``source`` itself."""
        folder = self.source / "final"
        return folder if folder.is_dir() else self.source

    def missing(self, given: Collection[str] = ()) -> list[str]:  # noqa: ARG002
        """Photos of a split, and the two matrices of each photo."""
        missing = []
        for split in SPLITS:
            photos = pictures_below(self._final / split / "rgb")
            if not photos:
                missing.append(f"{split}/rgb/")
            for kind in MATRICES:
                files = _matrix_files(self._final / split / kind, list(photos))
                missing += [f"{split}/{kind}/{stem_of(p)}.txt" for p in photos if p not in files]
        return missing + self.missing_evaluation()

    def read(self, effort: Effort) -> SourceScene:
        """All photos of both splits; their points are triangulated."""
        views: dict[str, SourceView] = {}
        for split in SPLITS:
            for view in self._views(split):
                if (other := views.setdefault(key_of(view.path), view)) is not view:
                    raise InputError(
                        f"{view.photo}: is in {other.split} and in {view.split}; leave it in one, "
                        "or the test is no test"
                    )
        require_training_views((view.split for view in views.values()), self._final)
        ordered = tuple(views[key] for key in sorted(views))
        points = triangulated_points(ordered, self.source, effort)
        return SourceScene(ordered, points, turn=self.settings.given_turn)

    def _views(self, split: Split) -> list[SourceView]:
        folder = self._final / split
        photos = pictures_below(folder / "rgb")
        masks = ByPhoto(mask_files(folder / "mask"), list(photos), str(folder / "mask"))
        labels = pictures_below(folder / "cityscapes_mask")
        by_photo = ByPhoto(labels, list(photos), str(folder / "cityscapes_mask"))
        evaluation = ByPhoto(
            read_evaluation(self.source / "eval_files"), list(photos), "test_config.py"
        )
        matrices = {kind: _matrix_files(folder / kind, list(photos)) for kind in MATRICES}
        views = []
        for path, photo in photos.items():
            mask = masks.get(path)
            files = []
            for kind in MATRICES:
                file = matrices[kind].get(path)
                if file is None:
                    raise InputError(
                        f"{folder / kind / stem_of(path)}.txt: no such file, but its photo is "
                        "there; put it in place or remove the photo"
                    )
                files.append(file)
            views.append(
                SourceView(
                    path=path,
                    photo=photo,
                    camera=_camera(photo, *files),
                    split=split,
                    session=session_of(path),
                    masks={} if mask is None else {"is_valid": mask},
                    labels=by_photo.get(path),
                    evaluation=evaluation.get(path),
                )
            )
        return views


def _matrix_files(folder: Path, photos: list[str]) -> ByPhoto[Path]:
    """Text files of one kind of matrix, by the photo that they belong to."""
    files = {
        path.relative_to(folder).as_posix(): path
        for path in files_below(folder)
        if path.suffix.lower() == ".txt"
    }
    return ByPhoto(files, photos, str(folder))


def _camera(photo: Path, pose_file: Path, intrinsics_file: Path) -> Camera:
    pose = pose_from_matrix(_matrix(pose_file), str(pose_file))
    matrix = _matrix(intrinsics_file)
    off_axis = matrix[[0, 1, 2, 2], [1, 0, 0, 1]]
    pinhole = np.abs(off_axis).max() <= 1e-6 and np.isclose(matrix[2, 2], 1.0, rtol=0, atol=1e-9)
    if not pinhole:
        raise InputError(
            f"{intrinsics_file}: is no pinhole camera (fx 0 cx; 0 fy cy; 0 0 1); correct the matrix"
        )
    width, height = picture_size(photo)
    parameters = tuple(float(matrix[index]) for index in ((0, 0), (1, 1), (0, 2), (1, 2)))
    return camera_of(pose, Lens("PINHOLE", width, height, parameters), str(intrinsics_file))


def _matrix(path: Path) -> NDArray[np.float64]:
    """The 4x4 matrix of a text file, on one line or four."""
    try:
        values = np.array(path.read_text(encoding="utf-8-sig").split(), dtype=np.float64)
    except (ValueError, UnicodeDecodeError):
        values = np.empty(0)
    if values.size != 16:
        raise InputError(f"{path}: does not hold the 16 numbers of a 4x4 matrix; copy it again")
    return values.reshape(4, 4)
