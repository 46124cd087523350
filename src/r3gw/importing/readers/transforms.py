"""transforms.json, as nerfstudio and instant-ngp write it: what is read, and what is refused.

nerfstudio: docs.nerf.studio, "Data conventions". instant-ngp adds ``is_fisheye`` and fields of view
in degrees (its page on data sets). Keys that r3gw does not know are harmless only if they
cannot change geometry: those that can are refused, others are counted and named.
"""

import codecs
import re
from collections.abc import Iterable, Mapping
from math import degrees, radians, tan
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from r3gw.files import InputError
from r3gw.importing.lens import Lens
from r3gw.importing.posed import picture_size

# nerfstudio takes all of these for a perspective camera with the distortion that k and p state.
_PERSPECTIVE = ("OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "PERSPECTIVE")
_FISHEYE = ("OPENCV_FISHEYE", "FISHEYE")
# A camera's geometry by other tools: more lens terms, other projections, moving shutters.
_GEOMETRY = re.compile(
    r"k\d+|p\d+|b\d+|s\d+|tau\w*|skew|distortion\w*|ftheta\w*|latlong|equirect\w*|\w*fisheye"
    r"|is_\w*(pano|ortho|equi|spher|360)\w*|ortho(graphic)?\w*|panoram\w*|lens_(mode|model|params|distortion)|rolling_shutter\w*|\w*projection\w*|crop_\w+|\w*_fov|fov\w*|radial|tangential",
    re.IGNORECASE,
)
_NEUTRAL: tuple[Any, ...] = (None, False, 0, 0.0, "", [], {})
# What both tools write and what says nothing of where a camera stands or what it sees.
_HARMLESS = frozenset(
    (
        *("aabb_scale", "applied_scale", "applied_transform", "bbox", "camera_label"),
        *("colmap_im_id", "crop", "depth_file_path", "depth_path", "depth_unit_scale_factor"),
        *("enable_depth_loading", "enable_ray_loading", "exposure", "fix_premult", "from_na"),
        *("integer_depth_scale", "n_extra_learnable_dims", "normal_file_path", "normals"),
        *("offset", "orientation_override", "render_aabb", "render_aabb_to_local", "scale"),
        *("scene", "sharpness", "time", "timestamp", "up", "white_transparent"),
    )
)


class _LensKeys(BaseModel):
    """Intrinsics, at the top of the file or of one frame."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=True)

    camera_model: str | None = None
    is_fisheye: bool | None = None
    camera_angle_x: float | None = None
    camera_angle_y: float | None = None
    x_fov: float | None = None
    y_fov: float | None = None
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


class Frame(_LensKeys):
    """One photo."""

    file_path: str
    transform_matrix: list[list[float]]
    mask_path: str | None = None


class Transforms(_LensKeys):
    """A whole transforms.json."""

    frames: list[Frame]
    ply_file_path: str | None = None
    train_filenames: list[str] | None = None
    test_filenames: list[str] | None = None
    val_filenames: list[str] | None = None


def read_transforms(path: Path) -> Transforms:
    """Read a transforms.json, in UTF-8 or, by its byte order mark, UTF-16.

    Raises:
        InputError: If it is missing, no text, no JSON, a value is missing or of the wrong kind,
            or a key changes the cameras in a way that r3gw does not read.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file; a nerfstudio folder holds it beside its photos")
    try:
        transforms = Transforms.model_validate_json(_text(path))
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"]) or "(whole file)"
        raise InputError(f"{path}: key '{key}': {first['msg']}; correct the file") from None
    for keys in (transforms, *transforms.frames):
        for key, value in (keys.model_extra or {}).items():
            if key not in _HARMLESS and _GEOMETRY.fullmatch(key) and value not in _NEUTRAL:
                raise InputError(
                    f"{path}: the key '{key}' ({_short(value)}) changes what the cameras see, and "
                    "r3gw does not read it; undistort the photos to PINHOLE and remove the key"
                )
    return transforms


def unread_keys(transforms: Transforms) -> list[str]:
    """Keys that nobody here knows, each once."""
    found = {key for keys in (transforms, *transforms.frames) for key in keys.model_extra or {}}
    return sorted(key for key in found if key not in _HARMLESS and not _GEOMETRY.fullmatch(key))


def lens_of(frame: Frame, transforms: Transforms, photo: Path, source: Path) -> Lens:
    """A frame's camera; what the frame does not state is taken from the top of the file.

    Args:
        frame: The photo's entry.
        transforms: The whole file.
        photo: The photo, whose size counts where the file states none.
        source: The file, for errors.

    Raises:
        InputError: If no focal length is stated, or the distortion is none that COLMAP's camera
            models have.
    """
    stated = transforms.model_dump(exclude_unset=True, exclude={"frames"})
    stated |= frame.model_dump(exclude_unset=True)
    values = _LensKeys.model_validate(stated)
    where = f"{source}: {frame.file_path}"
    width, height = _size(values, photo, where)
    fx = _focal(values.fl_x, values.camera_angle_x, values.x_fov, width, where)
    fy = _focal(values.fl_y, values.camera_angle_y, values.y_fov, height, where)
    if fx is None:
        fx = _focal(None, values.camera_angle_y, values.y_fov, height, where)
    if fx is None:
        raise InputError(f"{where}: transforms.json states no focal length (fl_x); add it")
    cx = 0.5 * width if values.cx is None else values.cx
    cy = 0.5 * height if values.cy is None else values.cy
    model, distortion = _distortion(values, where)
    parameters = (fx, fx if fy is None else fy, cx, cy, *distortion)
    return Lens(model, width, height, parameters)


def _text(path: Path) -> str:
    data = path.read_bytes()
    is_utf16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return data.decode("utf-16" if is_utf16 else "utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not text in UTF-8 (Latin-1?); save it as UTF-8") from None


def _size(values: _LensKeys, photo: Path, where: str) -> tuple[int, int]:
    if values.w is None or values.h is None:
        return picture_size(photo)
    for side in (values.w, values.h):
        if not 1 <= side <= 1e6 or side != round(side):
            raise InputError(f"{where}: the size {values.w:g}x{values.h:g} px is none; correct it")
    return int(values.w), int(values.h)


def _focal(
    stated: float | None, angle: float | None, fov_deg: float | None, side: int, where: str
) -> float | None:
    """A focal length in px, from itself or from the field of view along a side of ``side`` px."""
    if stated is not None:
        return stated
    if angle is None and fov_deg is not None:
        angle = radians(fov_deg)
    if angle is None:
        return None
    if not 0 < angle < radians(180):
        raise InputError(f"{where}: a field of view of {degrees(angle):g} degrees is none")
    return 0.5 * side / tan(0.5 * angle)


def _distortion(values: _LensKeys, where: str) -> tuple[str, list[float]]:
    """COLMAP's camera model and the parameters behind its first four."""
    radial = [values.k1, values.k2, values.k3, values.k4]
    tangential = [values.p1, values.p2]
    model = values.camera_model or ("OPENCV_FISHEYE" if values.is_fisheye else "OPENCV")
    if values.is_fisheye and model in _PERSPECTIVE:
        if values.camera_model not in (None, "OPENCV"):
            raise InputError(f"{where}: is_fisheye and camera_model {model} contradict each other")
        model = "OPENCV_FISHEYE"
    if model in _FISHEYE:
        if any(tangential):
            raise InputError(f"{where}: a fisheye camera has no p1 and p2; correct the file")
        return "OPENCV_FISHEYE", radial
    if model not in _PERSPECTIVE:
        raise InputError(
            f"{where}: transforms.json has the camera model {model}, but r3gw reads OPENCV, "
            "OPENCV_FISHEYE and PINHOLE; convert the photos to one of them"
        )
    if values.k4:
        raise InputError(
            f"{where}: k4 ({values.k4:g}) of a perspective camera is the factor of the radius to "
            "the eighth, which no camera model of COLMAP or OpenCV has; undistort the photos, or "
            "fit the camera again with k1 to k3"
        )
    if not any(radial + tangential):
        return "PINHOLE", []
    if values.k3:
        return "FULL_OPENCV", [*radial[:2], *tangential, values.k3, 0.0, 0.0, 0.0]
    return "OPENCV", [*radial[:2], *tangential]


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def named_files(transforms: Transforms) -> Iterable[str]:
    """Masks and the point cloud that the file names."""
    masks = (frame.mask_path for frame in transforms.frames)
    return (name for name in (*masks, transforms.ply_file_path) if name)


def split_names(transforms: Transforms) -> Mapping[str, list[str]] | None:
    """``train`` and ``test`` lists of the file, or None; without test photos, val ones are held."""
    if transforms.train_filenames is None:
        return None
    held_out = transforms.test_filenames or transforms.val_filenames or []
    return {"train": transforms.train_filenames, "test": held_out}
