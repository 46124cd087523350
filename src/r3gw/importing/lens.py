"""Lens distortion: the pinhole camera of a distorted one, and pictures and masks warped to it.

pycolmap warps; a photo and its masks go the same way, so they stay on top of each other. Its
cameras live inside these functions only: what is handed around is `Lens`, a plain value.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
import pycolmap
from numpy.typing import NDArray

_OPTIONS = pycolmap.UndistortCameraOptions()
_PINHOLES = ("PINHOLE", "SIMPLE_PINHOLE")

Intrinsics = tuple[float, float, float, float]


@dataclass(frozen=True)
class Lens:
    """A photo's camera as its format states it.

    Attributes:
        model: Name of a COLMAP camera model (colmap.github.io/cameras.html).
        width: Width of the photo in px.
        height: Height of the photo in px.
        parameters: The model's parameters in COLMAP's order.
    """

    model: str
    width: int
    height: int
    parameters: tuple[float, ...]

    @staticmethod
    def of(camera: pycolmap.Camera) -> "Lens":
        """Copy a camera of pycolmap, which may belong to a reconstruction and die with it."""
        parameters = tuple(float(value) for value in camera.params)
        return Lens(str(camera.model.name), int(camera.width), int(camera.height), parameters)

    @property
    def is_pinhole(self) -> bool:
        """Whether the camera has no distortion."""
        return self.model in _PINHOLES


@cache
def lens_models() -> Mapping[int, tuple[str, int]]:
    """Name and number of parameters of every camera model that COLMAP knows, by its id."""
    models = {}
    for name, identifier in pycolmap.CameraModelId.__members__.items():
        if identifier.value >= 0:
            example = pycolmap.Camera.create_from_model_id(1, identifier, 1.0, 1, 1)
            models[int(identifier.value)] = (str(name), len(example.params))
    return models


def pinhole(lens: Lens) -> tuple[Intrinsics, int, int]:
    """Intrinsics ``(fx, fy, cx, cy)``, width and height in px, without the distortion.

    Of a distorted camera the part is kept that the photo covers wholly.

    Raises:
        ValueError: If the model has no pinhole camera, as EQUIRECTANGULAR, or wrong parameters.
    """
    camera = _camera(lens)
    if not lens.is_pinhole:
        camera = pycolmap.undistort_camera(_OPTIONS, camera)
    matrix = camera.calibration_matrix()
    fx, fy, cx, cy = (float(matrix[index]) for index in ((0, 0), (1, 1), (0, 2), (1, 2)))
    return (fx, fy, cx, cy), int(camera.width), int(camera.height)


def undistorted(photo: NDArray[np.uint8], lens: Lens) -> NDArray[np.uint8]:
    """Warp a picture ``[H, W, 3]`` or ``[H, W]`` to the camera of `pinhole`, bilinearly."""
    bitmap = pycolmap.Bitmap.from_array(np.ascontiguousarray(photo))
    warped, _ = pycolmap.undistort_image(_OPTIONS, bitmap, _camera(lens))
    pixels: NDArray[np.uint8] = np.array(warped.to_array(), dtype=np.uint8)
    return pixels.reshape(pixels.shape[:2]) if photo.ndim == 2 else pixels


def undistorted_mask(mask: NDArray[np.bool_], lens: Lens) -> NDArray[np.bool_]:
    """Warp a mask ``[H, W]`` as `undistorted`; True where at least half is."""
    grey = undistorted(mask.astype(np.uint8) * np.uint8(255), lens)
    return np.asarray(grey >= 128)


def _camera(lens: Lens) -> pycolmap.Camera:
    return pycolmap.Camera(
        model=lens.model, width=lens.width, height=lens.height, params=list(lens.parameters)
    )
