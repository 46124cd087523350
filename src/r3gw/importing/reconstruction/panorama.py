"""Pictures that show all directions: 360-degree photos and stitched panoramas."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

# Google's Photo Sphere metadata, which 360-degree cameras and phones write (XMP, GPano).
_GPANO = re.compile(rb"""GPano:ProjectionType\s*(=\s*["']|>\s*)(equirectangular|cylindrical)""")
_HEADER_BYTES = 256 * 1024
_PLAIN = 8.0  # grey values: a picture with less contrast says nothing


def is_panorama(path: Path, pixels: NDArray[np.uint8]) -> bool:
    """Whether a picture is an equirectangular one, or a panorama by its own metadata.

    Being twice as wide as high is no proof, since photos are cropped so. It counts together with
    what only an equirectangular picture has: its left and right edges continue each other, and
    its first and last rows are one point each, the zenith and the nadir.

    Args:
        path: The file, for its metadata.
        pixels: ``[H, W, 3]``.
    """
    with path.open("rb") as stream:
        if _GPANO.search(stream.read(_HEADER_BYTES)):
            return True
    height, width = pixels.shape[:2]
    if width != 2 * height or height < 8:
        return False
    grey = pixels.astype(np.float32).mean(axis=2)
    if grey[height // 2].std() < _PLAIN:
        return False
    beside = np.abs(np.diff(grey, axis=1)).mean()
    around = np.abs(grey[:, 0] - grey[:, -1]).mean()
    poles = max(grey[0].std(), grey[-1].std())
    return bool(around <= 2.0 * beside + 1.0 and poles <= 0.25 * grey[height // 2].std())
