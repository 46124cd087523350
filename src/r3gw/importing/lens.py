"""Lens distortion: the pinhole camera of a distorted one, and pictures and masks warped to it.

pycolmap warps; a photo and its masks go the same way, so they stay on top of each other.
"""

import numpy as np
import pycolmap
from numpy.typing import NDArray

_OPTIONS = pycolmap.UndistortCameraOptions()
_PINHOLES = ("PINHOLE", "SIMPLE_PINHOLE")

Intrinsics = tuple[float, float, float, float]


def is_pinhole(camera: pycolmap.Camera) -> bool:
    """Whether the camera has no distortion."""
    return camera.model.name in _PINHOLES


def pinhole(camera: pycolmap.Camera) -> tuple[Intrinsics, int, int]:
    """Intrinsics ``(fx, fy, cx, cy)``, width and height in px, without the distortion.

    Of a distorted camera the part is kept that the photo covers wholly.
    """
    if not is_pinhole(camera):
        camera = pycolmap.undistort_camera(_OPTIONS, camera)
    matrix = camera.calibration_matrix()
    fx, fy, cx, cy = (float(matrix[index]) for index in ((0, 0), (1, 1), (0, 2), (1, 2)))
    return (fx, fy, cx, cy), int(camera.width), int(camera.height)


def undistorted(photo: NDArray[np.uint8], lens: pycolmap.Camera) -> NDArray[np.uint8]:
    """Warp a picture ``[H, W, 3]`` or ``[H, W]`` to the camera of `pinhole`, bilinearly."""
    bitmap = pycolmap.Bitmap.from_array(np.ascontiguousarray(photo))
    warped, _ = pycolmap.undistort_image(_OPTIONS, bitmap, lens)
    pixels: NDArray[np.uint8] = np.asarray(warped.to_array(), dtype=np.uint8)
    return pixels.reshape(pixels.shape[:2]) if photo.ndim == 2 else pixels


def undistorted_mask(mask: NDArray[np.bool_], lens: pycolmap.Camera) -> NDArray[np.bool_]:
    """Warp a mask ``[H, W]`` as `undistorted`; True where at least half is."""
    grey = undistorted(mask.astype(np.uint8) * np.uint8(255), lens)
    return np.asarray(grey >= 128)
