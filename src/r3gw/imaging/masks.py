"""Masks: polarity, size, erosion. In memory True means what the name says (``is_sky``).

On disk a mask is a grey picture; `read_mask` turns it into bool with white (>= 128) = True.
"""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.files import read_grey

WHITE_FROM = 128


def read_mask(path: Path, width: int | None = None, height: int | None = None) -> NDArray[np.bool_]:
    """Read a mask ``[H, W]``, True where white.

    Args:
        path: Grey picture.
        width, height: Size that the mask must have, in pixels; None accepts any.

    Raises:
        InputError: If the file is unreadable or of another size than its photo.
    """
    grey = read_grey(path)
    if width is not None and height is not None and grey.shape != (height, width):
        found = f"{grey.shape[1]}x{grey.shape[0]}"
        raise InputError(
            f"{path}: the mask is {found} px but its photo is {width}x{height} px; "
            "make the mask again at the photo's size"
        )
    mask: NDArray[np.bool_] = grey >= WHITE_FROM
    return mask


def resize_mask(mask: NDArray[np.bool_], width: int, height: int) -> NDArray[np.bool_]:
    """Scale a mask to ``width`` x ``height`` px by area and a threshold at one half."""
    if mask.shape == (height, width):
        return mask
    scaled = cv2.resize(mask.astype(np.float32), (width, height), interpolation=cv2.INTER_AREA)
    return np.asarray(scaled >= 0.5)


def erode(mask: NDArray[np.bool_], size_px: int) -> NDArray[np.bool_]:
    """Erode True areas by a ``size_px`` square; the frame's outside counts as True."""
    kernel = np.ones((size_px, size_px), np.uint8)
    return cv2.erode(mask.astype(np.uint8), kernel).astype(np.bool_)
