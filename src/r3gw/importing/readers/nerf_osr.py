"""Reader of NeRF-OSR scenes as LumiGauss prepared them, and of the embedded benchmark's own."""

from collections.abc import Collection, Mapping
from math import atan2, degrees, hypot
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from r3gw.files import InputError
from r3gw.files.names import inside
from r3gw.importing.evaluation_config import evaluated_views, read_evaluation
from r3gw.importing.folders import (
    evaluation_with_mask,
    mask_files,
    masks_beside,
    masks_of,
    notes_on_masks,
    photos_named,
    require_training_views,
    session_of,
)
from r3gw.importing.named_files import listed, pictures_below, pictures_by_key
from r3gw.importing.reader import Effort, Reader
from r3gw.importing.readers.colmap_model import model_suffix, read_model
from r3gw.importing.reconstruction.triangulate import with_points
from r3gw.importing.settings import NerfOsrScene, SyntheticScene
from r3gw.importing.source import SourceScene, SourceView
from r3gw.importing.split import SplitLine, find_split_file, read_split
from r3gw.scene import GroundTruth
from r3gw.scene.names import ByPhoto, stem_of
from r3gw.scene.scene import Row3
from r3gw.scene.sun_position import SunPosition

_EXTENSIONS = ("albedo", "normal", "depth")


class _TruthView(BaseModel):
    model_config = ConfigDict(allow_inf_nan=False)
    session: str
    exposure: Annotated[float, Field(gt=0)]
    white_balance: Row3


class _TruthSession(BaseModel):
    model_config = ConfigDict(allow_inf_nan=False)
    sun_direction: Row3


class _TruthFile(BaseModel):
    views: dict[str, _TruthView]
    sessions: dict[str, _TruthSession] = Field(default_factory=dict)


class NerfOsrReader(Reader[SyntheticScene | NerfOsrScene]):
    """``undistorted/``, ``eval_files/`` and, of the embedded benchmark, ``ground_truth/``."""

    @property
    def _undistorted(self) -> Path:
        return self.source / "undistorted"

    @property
    def _model(self) -> Path:
        return self._undistorted / "sparse" / "0"

    def _pictures(self) -> dict[str, Path]:
        """Photos by path; each must have a stem of its own, for its masks."""
        folder = self._undistorted / "images"
        pictures_by_key(folder)
        return pictures_below(folder)

    def missing(self, given: Collection[str] = ()) -> list[str]:
        """Model, photos of the split list, masks and entries that the settings ask for."""
        if not self._undistorted.is_dir():
            return ["undistorted/"]
        model = "undistorted/sparse/0/{cameras,images,points3D}.bin or .txt"
        missing = [] if model_suffix(self._model) else [model]
        lines = read_split(find_split_file(self._undistorted))
        pictures = self._pictures()
        found = photos_named(lines, pictures, self._undistorted)
        missing += [f"undistorted/images/{name}" for name in lines if name not in found]
        if "is_sky" in given:
            folder = self._undistorted / "sky_masks"
            masks = ByPhoto(mask_files(folder), list(lines), str(folder))
            missing += [f"undistorted/sky_masks/{stem_of(n)}.png" for n in lines if n not in masks]
        missing += self.missing_evaluation()
        if isinstance(self.settings, NerfOsrScene):
            missing += self._missing_of_evaluated(self.settings.evaluated_views, pictures)
        return missing

    def _missing_of_evaluated(self, views: list[str], pictures: Mapping[str, Path]) -> list[str]:
        evaluated = evaluated_views(self.source / "eval_files")
        stems = {stem_of(path).lower() for path in pictures}
        missing = []
        for view in views:
            if stem_of(view).lower() not in stems:
                missing.append(f"undistorted/images/{view}.jpg")
            if stem_of(view).lower() not in evaluated:
                missing.append(f"entry of {view} in eval_files/test_config.py")
        return missing

    def read(self, effort: Effort) -> SourceScene:
        """The photos that have a camera and a line in the split list."""
        if not self._undistorted.is_dir():
            raise InputError(
                f"{self.source}: no folder 'undistorted' here; see docs/data.md for the layout"
            )
        pictures = self._pictures()
        split_file = find_split_file(self._undistorted)
        lines = read_split(split_file)
        model = read_model(self._model)
        model.require_pinhole(self._model)
        by_line = _photos_of_list(lines, pictures, split_file)
        by_model = photos_named(model.cameras, pictures, self._model)
        cameras = {path: model.cameras[name] for name, path in by_model.items()}
        splits = {path: lines[name].split for name, path in by_line.items()}
        chosen = sorted(set(splits) & set(cameras))
        require_training_views((splits[path] for path in chosen), split_file)
        masks = masks_beside(self._undistorted, list(pictures))
        eval_masks = ByPhoto(
            mask_files(self.source / "eval_files" / "eval_mask"), list(pictures), "eval_mask"
        )
        evaluation = ByPhoto(
            read_evaluation(self.source / "eval_files"), chosen, "eval_files/test_config.py"
        )
        known = _read_truth(self.source / "ground_truth")
        facts = _ground_truth(known, self.source / "ground_truth")
        truth = ByPhoto(facts, chosen, "ground_truth.json")
        suns = ByPhoto(_true_suns(known), chosen, "ground_truth.json")
        views = [
            SourceView(
                path=path,
                photo=pictures[path],
                camera=cameras[path],
                split=splits[path],
                session=session_of(path),
                masks=masks_of(masks, path),
                evaluation=evaluation_with_mask(evaluation.get(path), eval_masks.get(path)),
                truth=truth.get(path),
                sun=suns.get(path),
            )
            for path in chosen
        ]
        points, triangulated = with_points(views, model.points, self.source, effort)
        unknown = "test_config.py has entries for views not in the scene: "
        return SourceScene(
            tuple(views),
            points,
            turn=np.eye(3),
            left_out=_left_out(pictures, splits, cameras, split_file),
            notes=(
                *triangulated,
                *notes_on_masks(masks),
                *((unknown + listed(evaluation.unused),) if evaluation.unused else ()),
            ),
        )


def _photos_of_list(
    lines: Mapping[str, SplitLine], pictures: Mapping[str, Path], split_file: Path
) -> dict[str, str]:
    """The picture of every line.

    Raises:
        InputError: If a line's photo is not there.
    """
    found = photos_named(lines, pictures, split_file)
    if missing := [line.filename for name, line in lines.items() if name not in found]:
        raise InputError(
            f"{split_file}: names photos that are not in images/ ({listed(missing)}); "
            "put them there or take them out of the list"
        )
    return found


def _left_out(
    pictures: Mapping[str, Path],
    splits: Mapping[str, object],
    cameras: Mapping[str, object],
    split_file: Path,
) -> dict[str, str]:
    reasons = {}
    for path in pictures:
        if path not in splits:
            reasons[path] = f"not in {split_file.name}"
        elif path not in cameras:
            reasons[path] = "not in the COLMAP model"
    return reasons


def _read_truth(folder: Path) -> _TruthFile:
    """``ground_truth.json`` of the embedded benchmark; nothing where the data has none."""
    path = folder / "ground_truth.json"
    if not path.is_file():
        return _TruthFile(views={})
    try:
        return _TruthFile.model_validate_json(path.read_bytes())
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{path}: key '{key}': {first['msg']}") from None


def _ground_truth(content: _TruthFile, folder: Path) -> dict[str, GroundTruth]:
    source = str(folder / "ground_truth.json")
    return {
        name: GroundTruth(
            exposure=view.exposure,
            white_balance=view.white_balance,
            env_map=str(inside(folder, f"envmaps/{view.session}.exr", source)),
            **{kind: str(inside(folder, f"{kind}/{name}.exr", source)) for kind in _EXTENSIONS},
        )
        for name, view in content.views.items()
    }


def _true_suns(content: _TruthFile) -> dict[str, SunPosition]:
    """The sun of each view, as time and place would tell it; north is +z in the made scenes."""
    suns = {}
    for name, view in content.views.items():
        if view.session in content.sessions:
            x, y, z = content.sessions[view.session].sun_direction
            elevation = degrees(atan2(-y, hypot(x, z)))
            suns[name] = SunPosition(
                elevation_deg=elevation, azimuth_deg=degrees(atan2(x, z)) % 360
            )
    return suns
