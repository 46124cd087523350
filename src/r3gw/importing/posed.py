"""Cameras that a dataset states as matrices: from any convention to ours, checked."""

from pathlib import Path

import numpy as np
import pycolmap
import torch
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.imaging.files import read_rgb_as_stored
from r3gw.importing.lens import Intrinsics, pinhole

_TURN_TOLERANCE = 1e-3
_REMEDY = "correct it or remove the photo"


def cam_from_world(world_from_cam: NDArray[np.float64], source: str) -> NDArray[np.float64]:
    """Invert a camera's pose ``[4, 4]`` with OpenCV axes (x right, y down, z forward).

    Args:
        world_from_cam: As the dataset states it; its rotation may be rounded.
        source: Names file and photo in errors.

    Raises:
        InputError: If the pose holds NaN, or is no rotation with a translation.
    """
    if not np.isfinite(world_from_cam).all():
        raise InputError(f"{source}: the pose holds NaN or infinity; {_REMEDY}")
    turn = world_from_cam[:3, :3]
    left, stretch, right = np.linalg.svd(turn)
    rigid = np.abs(stretch - 1.0).max() < _TURN_TOLERANCE and np.linalg.det(turn) > 0
    if not rigid or not np.allclose(world_from_cam[3], (0, 0, 0, 1), rtol=0, atol=1e-6):
        raise InputError(f"{source}: the pose is no rotation with a translation; {_REMEDY}")
    result = np.eye(4)
    result[:3, :3] = (left @ right).T
    result[:3, 3] = -result[:3, :3] @ world_from_cam[:3, 3]
    return result


def camera_of(
    pose: NDArray[np.float64], intrinsics: Intrinsics, width: int, height: int, source: str
) -> Camera:
    """A camera from ``cam_from_world`` ``[4, 4]``, ``(fx, fy, cx, cy)`` and size, all in px.

    Raises:
        InputError: If a value is NaN or infinite, or a focal length or side is not positive.
    """
    values = np.append(pose.ravel(), intrinsics)
    if not np.isfinite(values).all() or min(*intrinsics[:2], width, height) <= 0:
        fx = intrinsics[0]
        raise InputError(
            f"{source}: the camera is not usable (NaN in its pose or intrinsics, or a focal length "
            f"of {fx:g} px); {_REMEDY}"
        )
    return Camera(torch.from_numpy(pose), intrinsics, width, height)


def camera_without_lens(pose: NDArray[np.float64], lens: pycolmap.Camera, source: str) -> Camera:
    """The pinhole camera of a possibly distorted one.

    Raises:
        InputError: As `camera_of`.
    """
    if not np.isfinite(lens.params).all():
        raise InputError(f"{source}: the camera's parameters hold NaN or infinity; {_REMEDY}")
    return camera_of(pose, *pinhole(lens), source)


def picture_size(path: Path) -> tuple[int, int]:
    """Width and height of a picture's stored pixels.

    Raises:
        InputError: If the file is missing or no picture.
    """
    height, width = read_rgb_as_stored(path).shape[:2]
    return width, height
