"""Reader of NeRF-OSR scenes as LumiGauss prepared them, and of our synthetic ones (data.md A)."""

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.importing.evaluation_config import read_evaluation
from r3gw.importing.folders import (
    evaluation_with_mask,
    masks_beside,
    require_training_views,
    session_of,
)
from r3gw.importing.named_files import key_of, listed, pictures_by_key
from r3gw.importing.readers.colmap_model import read_model
from r3gw.importing.source import SourceMask, SourceScene, SourceView
from r3gw.importing.split import SplitLine, find_split_file, read_split
from r3gw.scene import GroundTruth
from r3gw.scene.scene import Row3

_LOG = logging.getLogger(__name__)
_EXTENSIONS = ("albedo", "normal", "depth")


class _TruthView(BaseModel):
    model_config = ConfigDict(allow_inf_nan=False)
    session: str
    exposure: Annotated[float, Field(gt=0)]
    white_balance: Row3


class _TruthFile(BaseModel):
    views: dict[str, _TruthView]


def read_layout_a(source: Path) -> SourceScene:
    """Read ``source/undistorted``, ``source/eval_files`` and ``source/ground_truth``.

    Raises:
        InputError: On a missing file, a wrong size or an unreadable value; names it.
    """
    undistorted = source / "undistorted"
    if not undistorted.is_dir():
        raise InputError(f"{source}: no folder 'undistorted' here; see config/README.md for layout")
    photos = pictures_by_key(undistorted / "images")
    split_file = find_split_file(undistorted)
    splits = read_split(split_file)
    model = read_model(undistorted / "sparse" / "0")
    model.require_pinhole(undistorted / "sparse" / "0")
    cameras = {key_of(name): camera for name, camera in model.cameras.items()}
    if len(cameras) < len(model.cameras):
        raise InputError(f"{undistorted / 'sparse' / '0'}: two images share a stem; rename one")
    chosen = _chosen(photos, splits, cameras, split_file)
    masks = masks_beside(undistorted)
    eval_masks = pictures_by_key(source / "eval_files" / "eval_mask")
    masks["eval"] = {key: SourceMask(path) for key, path in eval_masks.items()}
    evaluation = read_evaluation(source / "eval_files")
    truth = _ground_truth(source / "ground_truth")
    if unknown := set(evaluation) - set(chosen):
        _LOG.warning("test_config.py has entries for views not in the scene: %s", listed(unknown))
    views = []
    for key in chosen:
        name = photos[key].stem
        views.append(
            SourceView(
                name=name,
                photo=photos[key],
                camera=cameras[key],
                split=splits[key].split,
                session=session_of(name),
                masks={kind: files[key] for kind, files in masks.items() if key in files},
                evaluation=evaluation_with_mask(evaluation.get(key), masks["eval"].get(key)),
                truth=truth.get(key),
            )
        )
    return SourceScene(tuple(views), model.points)


def _chosen(
    photos: Mapping[str, Path],
    splits: Mapping[str, SplitLine],
    cameras: Mapping[str, Camera],
    split_file: Path,
) -> list[str]:
    """Keys of the views that have a photo, a camera and a split."""
    if missing := [line.filename for key, line in splits.items() if key not in photos]:
        raise InputError(
            f"{split_file}: names photos that are not in images/ ({listed(missing)}); "
            "put them there or take them out of the list"
        )
    if unposed := [line.filename for key, line in splits.items() if key not in cameras]:
        _LOG.warning("left out, not in the COLMAP model: %s", listed(unposed))
    if unlisted := [photos[key].name for key in cameras if key in photos and key not in splits]:
        _LOG.warning("left out, not in %s: %s", split_file.name, listed(unlisted))
    chosen = sorted(set(splits) & set(cameras))
    require_training_views((splits[key].split for key in chosen), split_file)
    return chosen


def _ground_truth(folder: Path) -> dict[str, GroundTruth]:
    path = folder / "ground_truth.json"
    if not path.is_file():
        return {}
    try:
        content = _TruthFile.model_validate_json(path.read_text())
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{path}: key '{key}': {first['msg']}") from None
    return {
        key_of(name): GroundTruth(
            exposure=view.exposure,
            white_balance=view.white_balance,
            env_map=str(folder / "envmaps" / f"{view.session}.exr"),
            **{kind: str(folder / kind / f"{name}.exr") for kind in _EXTENSIONS},
        )
        for name, view in content.views.items()
    }
