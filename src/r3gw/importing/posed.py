"""The one door for cameras: whatever a format states is checked and brought to our convention.

Readers hand in a pose (a matrix or a quaternion) and a `Lens`; what comes out is a `Camera`. A
value that cannot be meant is refused here, in one sentence, and nowhere else.
"""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.imaging.files import read_rgb_as_stored
from r3gw.importing.lens import Lens, lens_models, pinhole

# How far a rotation may be off its unit: text with three digits stays within.
_TURN_TOLERANCE = 1e-3
_QUATERNION_TOLERANCE = 1e-2
# Focal lengths in units of the photo's longer side: half a globe to the longest telescopes.
_FOCAL_RANGE = (0.02, 1000.0)
_LEAST_TO_DOUBT_PX = 16  # in larger photos no principal point is within a pixel of the corner
_LARGEST_SIDE_PX = 100_000
MOST_UNITS = 1e12  # that anything may lie from the origin; the globe measures 6e6 metres
_REMEDY = "correct it or remove the photo"


def pose_from_matrix(world_from_cam: NDArray[np.float64], source: str) -> NDArray[np.float64]:
    """Invert a camera's pose ``[4, 4]`` with OpenCV axes (x right, y down, z forward).

    Args:
        world_from_cam: As the dataset states it; its rotation may be rounded.
        source: Names file and photo in errors.

    Returns:
        The rigid ``cam_from_world``, ``[4, 4]``.

    Raises:
        InputError: If the pose holds NaN, or is no rotation with a translation.
    """
    if not np.isfinite(world_from_cam).all():
        raise InputError(f"{source}: the pose holds NaN or infinity; {_REMEDY}")
    _require_near(world_from_cam[:3, 3], source)
    turn = world_from_cam[:3, :3]
    left, stretch, right = np.linalg.svd(turn)
    rigid = np.abs(stretch - 1.0).max() < _TURN_TOLERANCE and np.linalg.det(turn) > 0
    if not rigid or not np.allclose(world_from_cam[3], (0, 0, 0, 1), rtol=0, atol=1e-6):
        raise InputError(f"{source}: the pose is no rotation with a translation; {_REMEDY}")
    result = np.eye(4)
    result[:3, :3] = (left @ right).T
    result[:3, 3] = -result[:3, :3] @ world_from_cam[:3, 3]
    return result


def pose_from_quaternion(
    quaternion: Sequence[float], translation: Sequence[float], source: str
) -> NDArray[np.float64]:
    """``cam_from_world`` ``[4, 4]`` of a quaternion ``wxyz`` and a translation, as COLMAP has them.

    Raises:
        InputError: If a value is NaN or infinite, or the quaternion's length is more than one per
            cent off 1; a smaller rounding is taken out.
    """
    wxyz = np.asarray(quaternion, dtype=np.float64)
    shift = np.asarray(translation, dtype=np.float64)
    if not np.isfinite(wxyz).all() or not np.isfinite(shift).all():
        raise InputError(f"{source}: the pose holds NaN or infinity; {_REMEDY}")
    _require_near(shift, source)
    length = math.hypot(*wxyz)
    if abs(length - 1.0) > _QUATERNION_TOLERANCE:
        raise InputError(
            f"{source}: the pose's quaternion has the length {length:g} instead of 1, so it is no "
            "rotation; normalise it or make the model again"
        )
    w, x, y, z = wxyz / length
    result = np.eye(4)
    result[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    result[:3, 3] = shift
    return result


def camera_of(cam_from_world: NDArray[np.float64], lens: Lens, source: str) -> Camera:
    """The pinhole camera of a pose ``[4, 4]`` and a lens; a distorted lens is straightened.

    Raises:
        InputError: If a value is NaN or infinite, the photo's size is none, a focal length or the
            principal point cannot belong to the photo, or the lens has no pinhole camera.
    """
    _check_lens(lens, source)
    try:
        intrinsics, width, height = pinhole(lens)
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{source}: the camera cannot be undistorted ({reason})") from None
    _require_near(cam_from_world[:3, 3], source)
    values = np.append(cam_from_world.ravel(), intrinsics)
    if not np.isfinite(values).all() or min(*intrinsics[:2], width, height) <= 0:
        raise InputError(
            f"{source}: without its distortion the camera is not usable ({lens.model} with the "
            f"parameters {_listed(lens)}); {_REMEDY}"
        )
    return Camera(torch.from_numpy(cam_from_world), intrinsics, width, height)


def picture_size(path: Path) -> tuple[int, int]:
    """Width and height of a picture's stored pixels.

    Raises:
        InputError: If the file is missing or no picture.
    """
    height, width = read_rgb_as_stored(path).shape[:2]
    return width, height


def _require_near(shift: NDArray[np.float64], source: str) -> None:
    away = float(np.abs(shift).max())
    if not away <= MOST_UNITS:
        raise InputError(f"{source}: the camera is {away:g} units away; {_REMEDY}")


def _check_lens(lens: Lens, source: str) -> None:
    counts = dict(lens_models().values())
    if lens.model not in counts or len(lens.parameters) != counts[lens.model]:
        raise InputError(
            f"{source}: the camera is {lens.model} with {len(lens.parameters)} parameters, which "
            f"COLMAP does not know; {_REMEDY}"
        )
    if not np.isfinite(lens.parameters).all():
        raise InputError(f"{source}: the camera's parameters hold NaN or infinity; {_REMEDY}")
    if not 0 < min(lens.width, lens.height) <= max(lens.width, lens.height) <= _LARGEST_SIDE_PX:
        raise InputError(f"{source}: the camera is {lens.width}x{lens.height} px; {_REMEDY}")
    if lens.model == "EQUIRECTANGULAR":
        raise InputError(
            f"{source}: the camera is EQUIRECTANGULAR (a 360-degree picture), which has no "
            "pinhole camera; split the pictures into cube faces and make the model again"
        )
    *focal, cx, cy = lens.parameters[: 3 if _has_one_focal_length(lens.model) else 4]
    longer = max(lens.width, lens.height)
    least, most = (factor * longer for factor in _FOCAL_RANGE)
    for value in focal:
        if not least <= value <= most:
            raise InputError(
                f"{source}: a focal length of {value:g} px cannot belong to a photo of "
                f"{lens.width}x{lens.height} px (it is stated in pixels); {_REMEDY}"
            )
    if longer > _LEAST_TO_DOUBT_PX and 0 <= min(cx, cy) <= max(cx, cy) <= 1:
        raise InputError(
            f"{source}: the principal point ({cx:g}, {cy:g}) is stated in pixels, so it would lie "
            f"in the corner of the photo of {lens.width}x{lens.height} px; {_REMEDY}"
        )
    if not (-lens.width <= cx <= 2 * lens.width and -lens.height <= cy <= 2 * lens.height):
        raise InputError(
            f"{source}: the principal point ({cx:g}, {cy:g}) px lies far outside the photo of "
            f"{lens.width}x{lens.height} px; {_REMEDY}"
        )


def _has_one_focal_length(model: str) -> bool:
    return model.startswith("SIMPLE_") or model in ("RADIAL", "RADIAL_FISHEYE")


def _listed(lens: Lens) -> str:
    return ", ".join(f"{value:g}" for value in lens.parameters)
