"""Reader of nerfstudio folders: photos and transforms.json (docs.nerf.studio, "Data conventions").

Its cameras look along -z with y up (OpenGL), and its world has z up; intrinsics are those of
COLMAP (pixel centres at +0.5).
"""

import logging
from math import tan
from pathlib import Path

import numpy as np
import pycolmap
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from r3gw.files import InputError
from r3gw.imaging.files import LDR_SUFFIXES
from r3gw.importing.evaluation_config import read_evaluation
from r3gw.importing.folders import masks_beside, require_training_views, session_of, split_beside
from r3gw.importing.lens import is_pinhole
from r3gw.importing.named_files import key_of, listed
from r3gw.importing.posed import cam_from_world, camera_without_lens, picture_size
from r3gw.importing.readers.ply_points import read_ply_points
from r3gw.importing.reconstruction.triangulate import triangulated_points
from r3gw.importing.source import MaskKind, SourceMask, SourceScene, SourceView
from r3gw.importing.split import Split

# scene (up -y) from nerfstudio's world (up z); the same turn that its COLMAP import takes back.
UPRIGHT_FROM_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
_OPENCV_FROM_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])
_LOG = logging.getLogger(__name__)


class _Lens(BaseModel):
    """Intrinsics, at the top of the file or of one frame."""

    camera_model: str | None = None
    camera_angle_x: float | None = None
    fl_x: float | None = None
    fl_y: float | None = None
    cx: float | None = None
    cy: float | None = None
    w: float | None = None
    h: float | None = None
    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    k4: float = 0.0
    p1: float = 0.0
    p2: float = 0.0


class _Frame(_Lens):
    file_path: str
    transform_matrix: list[list[float]]
    mask_path: str | None = None


class Transforms(_Lens):
    """What r3gw reads of transforms.json; other keys are ignored."""

    frames: list[_Frame]
    ply_file_path: str | None = None
    train_filenames: list[str] | None = None
    test_filenames: list[str] | None = None


def read_transforms(source: Path) -> Transforms:
    """Read ``source/transforms.json``.

    Raises:
        InputError: If it is missing, no JSON, or a value is missing or of the wrong kind.
    """
    path = source / "transforms.json"
    if not path.is_file():
        raise InputError(f"{path}: no such file; a nerfstudio folder holds it beside its photos")
    try:
        return Transforms.model_validate_json(path.read_bytes())
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"]) or "(whole file)"
        raise InputError(f"{path}: key '{key}': {first['msg']}; correct the file") from None


def read_nerfstudio(source: Path, *, num_threads: int, seed: int) -> SourceScene:
    """Read transforms.json with its photos, masks and points; points are triangulated if absent.

    Raises:
        InputError: On a missing file, a wrong size or an unreadable value; names it.
    """
    transforms = read_transforms(source)
    splits = _splits(transforms, source)
    evaluation = read_evaluation(source / "eval_files")
    beside = masks_beside(source)
    views: dict[str, SourceView] = {}
    for frame in transforms.frames:
        photo = photo_of(source, frame.file_path)
        key = key_of(photo.name)
        if key in views:
            raise InputError(
                f"{photo}: has the same stem as {views[key].photo.name}, but views are told apart "
                "by stem; rename or remove one of the two"
            )
        if key not in splits:
            continue
        masks: dict[MaskKind, SourceMask] = {k: m[key] for k, m in beside.items() if key in m}
        if frame.mask_path is not None:
            masks["is_valid"] = SourceMask(source / frame.mask_path)
        lens = _lens(frame, transforms, photo)
        views[key] = SourceView(
            name=photo.stem,
            photo=photo,
            camera=camera_without_lens(_pose(frame, photo), lens, str(photo)),
            split=splits[key],
            session=session_of(photo.stem),
            masks=masks,
            evaluation=evaluation.get(key),
            lens=None if is_pinhole(lens) else lens,
        )
    require_training_views((view.split for view in views.values()), source / "transforms.json")
    ordered = tuple(views[key] for key in sorted(views))
    if transforms.ply_file_path is not None:
        return SourceScene(ordered, read_ply_points(source / transforms.ply_file_path))
    points = triangulated_points(ordered, source, num_threads=num_threads, seed=seed)
    return SourceScene(ordered, points)


def photo_of(source: Path, file_path: str) -> Path:
    """The photo that a frame names; its suffix may be left out. It need not exist."""
    written = source / file_path
    endings = ("", *LDR_SUFFIXES, *(suffix.upper() for suffix in LDR_SUFFIXES))
    candidates = [written.with_name(written.name + ending) for ending in endings]
    return next((path for path in candidates if path.is_file()), written)


def _splits(transforms: Transforms, source: Path) -> dict[str, Split]:
    """The split by key: the file's own lists, else a ``*_split.csv``, else all for training."""
    names = [frame.file_path for frame in transforms.frames]
    if transforms.train_filenames is None:
        return split_beside(source, names)
    splits: dict[str, Split] = {key_of(name): "train" for name in transforms.train_filenames}
    splits |= {key_of(name): "test" for name in transforms.test_filenames or ()}
    if left := [name for name in names if key_of(name) not in splits]:
        _LOG.warning("left out, in neither train_filenames nor test_filenames: %s", listed(left))
    return splits


def _pose(frame: _Frame, photo: Path) -> NDArray[np.float64]:
    rows = frame.transform_matrix
    if len(rows) not in (3, 4) or any(len(row) != 4 for row in rows):
        raise InputError(f"{photo}: 'transform_matrix' is not 4x4; correct transforms.json")
    world_from_opengl = np.array([*rows[:3], [0.0, 0.0, 0.0, 1.0]])
    return cam_from_world(world_from_opengl @ _OPENCV_FROM_OPENGL, str(photo))


def _lens(frame: _Frame, transforms: Transforms, photo: Path) -> pycolmap.Camera:
    """A frame's camera; what the frame does not state is taken from the top of the file."""
    stated = transforms.model_dump(exclude_unset=True) | frame.model_dump(exclude_unset=True)
    values = _Lens.model_validate(stated)
    size = (values.w, values.h) if values.w and values.h else picture_size(photo)
    width, height = (round(side) for side in size)
    fx = values.fl_x
    if fx is None and values.camera_angle_x is not None:
        fx = 0.5 * width / tan(0.5 * values.camera_angle_x)
    if fx is None:
        raise InputError(f"{photo}: transforms.json states no focal length (fl_x); add it")
    cx = 0.5 * width if values.cx is None else values.cx
    cy = 0.5 * height if values.cy is None else values.cy
    model, distortion = _distortion(values, photo)
    parameters = [fx, fx if values.fl_y is None else values.fl_y, cx, cy, *distortion]
    return pycolmap.Camera(model=model, width=width, height=height, params=parameters)


def _distortion(values: _Lens, photo: Path) -> tuple[str, list[float]]:
    """COLMAP's camera model and the parameters behind its first four."""
    radial = [values.k1, values.k2, values.k3, values.k4]
    tangential = [values.p1, values.p2]
    model = values.camera_model or "OPENCV"
    if model == "OPENCV_FISHEYE":
        return model, radial
    if model not in ("OPENCV", "PINHOLE", "SIMPLE_PINHOLE"):
        raise InputError(
            f"{photo}: transforms.json has the camera model {model}, but r3gw reads OPENCV, "
            "OPENCV_FISHEYE and PINHOLE; convert the photos to one of them"
        )
    if model != "OPENCV" or not any(radial + tangential):
        return "PINHOLE", []
    if values.k3 or values.k4:
        return "FULL_OPENCV", [*radial[:2], *tangential, *radial[2:], 0.0, 0.0]
    return "OPENCV", [*radial[:2], *tangential]
