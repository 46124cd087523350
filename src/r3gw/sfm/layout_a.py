"""Reader of NeRF-OSR scenes as LumiGauss prepared them, and of our synthetic ones (data.md A)."""

import logging
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.scene import EvaluationEntry, GroundTruth
from r3gw.scene.scene import Row3
from r3gw.sfm.colmap_model import read_model
from r3gw.sfm.evaluation_config import read_evaluation
from r3gw.sfm.named_files import key_of, listed, pictures_by_key
from r3gw.sfm.source import MaskKind, SourceMask, SourceScene, SourceView
from r3gw.sfm.split import Split, find_split_file, read_split

_LOG = logging.getLogger(__name__)
_SESSION = re.compile(r"^(\d\d-\d\d_\d\d_\d\d)_")
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
    cameras = {key_of(name): camera for name, camera in model.cameras.items()}
    if len(cameras) < len(model.cameras):
        raise InputError(f"{undistorted / 'sparse' / '0'}: two images share a stem; rename one")
    chosen = _chosen(photos, splits, cameras, split_file)
    masks = _masks(undistorted, source / "eval_files")
    evaluation = read_evaluation(source / "eval_files")
    truth = _ground_truth(source / "ground_truth")
    if unknown := set(evaluation) - set(chosen):
        _LOG.warning("test_config.py has entries for views not in the scene: %s", listed(unknown))
    views = []
    for key in chosen:
        name = photos[key].stem
        session = _SESSION.match(name)
        views.append(
            SourceView(
                name=name,
                photo=photos[key],
                camera=cameras[key],
                split=splits[key],
                session=session.group(1) if session else None,
                masks={kind: files[key] for kind, files in masks.items() if key in files},
                evaluation=_with_mask(evaluation.get(key), masks["eval"].get(key)),
                truth=truth.get(key),
            )
        )
    return SourceScene(tuple(views), model.points)


def _chosen(
    photos: Mapping[str, Path],
    splits: Mapping[str, Split],
    cameras: Mapping[str, Camera],
    split_file: Path,
) -> list[str]:
    """Keys of the views that have a photo, a camera and a split."""
    if missing := set(splits) - set(photos):
        raise InputError(
            f"{split_file}: names photos that are not in images/ ({listed(missing)}); "
            "put them there or take them out of the list"
        )
    if unposed := set(splits) - set(cameras):
        _LOG.warning("left out, not in the COLMAP model: %s", listed(unposed))
    if unlisted := set(cameras) - set(splits):
        _LOG.warning("left out, not in %s: %s", split_file.name, listed(unlisted))
    chosen = sorted(set(splits) & set(cameras))
    if not any(splits[key] == "train" for key in chosen):
        raise InputError(
            f"{split_file}: no training photo is left ({len(splits)} photos listed, "
            f"{len(cameras)} in the COLMAP model); check that both name the same files"
        )
    return chosen


def _masks(undistorted: Path, eval_files: Path) -> dict[MaskKind, dict[str, SourceMask]]:
    folders: dict[MaskKind, tuple[Path, bool]] = {
        "is_valid": (undistorted / "masks", True),
        "is_sky": (undistorted / "sky_masks", False),  # white = NOT sky
        "eval": (eval_files / "eval_mask", True),
    }
    return {
        kind: {key: SourceMask(path, white) for key, path in pictures_by_key(folder).items()}
        for kind, (folder, white) in folders.items()
    }


def _with_mask(entry: EvaluationEntry | None, mask: SourceMask | None) -> EvaluationEntry | None:
    """An entry without a mask path of its own takes the one of eval_mask/."""
    if entry is None or entry.mask is not None or mask is None:
        return entry
    return entry.model_copy(update={"mask": str(mask.path)})


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
