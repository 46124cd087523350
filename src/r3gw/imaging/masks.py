"""Masks: polarity, size, erosion. In memory True means what the name says (``is_sky``).

On disk a mask is a picture whose white is True. White is the upper half of its range, and the range
is what the values show: 0 and 1, 0 and 255, and 0 and 65535 mean the same. Where its shape is in
an alpha channel, what is opaque is True.
"""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.decode import Picture, Pixels, read_picture


@dataclass(frozen=True)
class MaskLevels:
    """A mask with the values that it was made from, for sentences about suspicious masks.

    Attributes:
        is_white: ``[H, W]``, True where white (or opaque).
        lowest, highest: Values found.
        white_from: Values from here on are white.
    """

    is_white: NDArray[np.bool_]
    lowest: float
    highest: float
    white_from: float

    def described(self) -> str:
        """The range, for people."""
        return (
            f"values from {self.lowest:g} to {self.highest:g}, white begins at {self.white_from:g}"
        )


def read_mask(path: Path, width: int | None = None, height: int | None = None) -> NDArray[np.bool_]:
    """Read a mask ``[H, W]``, True where white.

    Args:
        path: Grey picture, or one whose shape is in its alpha channel.
        width, height: Size that the mask must have, in pixels; None accepts any.

    Raises:
        InputError: If the file is unreadable or of another size than its photo.
    """
    return read_mask_levels(path, width, height).is_white


def read_mask_levels(path: Path, width: int | None = None, height: int | None = None) -> MaskLevels:
    """As `read_mask`, together with the range of the file's values.

    Raises:
        InputError: As `read_mask`.
    """
    mask = _levels_of(read_picture(path))
    if width is not None and height is not None and mask.is_white.shape != (height, width):
        found = f"{mask.is_white.shape[1]}x{mask.is_white.shape[0]}"
        raise InputError(
            f"{path}: the mask is {found} px but its photo is {width}x{height} px; "
            "make the mask again at the photo's size"
        )
    return mask


def _levels_of(picture: Picture) -> MaskLevels:
    if picture.alpha is None or picture.is_opaque is None:
        return _levels(_grey(picture))
    alpha = _levels(picture.alpha)
    if not alpha.is_white.any() or _is_plain(picture, alpha.is_white):
        return alpha
    colour = _levels(_grey(picture))
    both = colour.is_white & alpha.is_white
    return MaskLevels(both, colour.lowest, colour.highest, colour.white_from)


def _grey(picture: Picture) -> Pixels:
    if picture.pixels.ndim == 2:
        return picture.pixels
    return np.asarray(cv2.cvtColor(picture.pixels, cv2.COLOR_RGB2GRAY), picture.pixels.dtype)


def _is_plain(picture: Picture, where: NDArray[np.bool_]) -> bool:
    """Whether the picture has one colour where it is opaque, so that its shape is in alpha."""
    colours = picture.pixels[where]
    return bool((colours == colours[0]).all())


def _levels(values: Pixels) -> MaskLevels:
    lowest, highest = float(values.min()), float(values.max())
    if highest <= 1.0:
        white_from = 0.5 if values.dtype == np.float32 else 1.0
    else:
        white_from = 128.0 if highest <= 255.0 else 32768.0
    return MaskLevels(np.asarray(values >= white_from), lowest, highest, white_from)


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
