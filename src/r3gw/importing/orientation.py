"""EXIF orientation: masks turned as their photos are."""

from pathlib import Path

import numpy as np
import pycolmap
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.files import read_rgb
from r3gw.imaging.masks import read_mask

# EXIF 2.32, tag 0x0112: what makes the stored picture of a photo taken upright right.
_QUARTER_TURNS = {5: (0, True), 6: (3, False), 7: (2, True), 8: (1, False)}


def upright_mask(path: Path, photo: Path) -> NDArray[np.bool_]:
    """A photo's mask ``[H, W]``, True where white, of the size of the photo as people see it.

    A mask of that size is taken as it is. One of the size of the stored pixels, where EXIF swaps
    width and height, is turned as EXIF says.

    Raises:
        InputError: If the mask is unreadable or of another size.
    """
    mask = read_mask(path)
    height, width = read_rgb(photo).shape[:2]
    if mask.shape == (height, width):
        return mask
    bitmap = pycolmap.Bitmap.read(photo, as_rgb=False)
    orientation = None if bitmap is None else bitmap.exif_orientation()
    if mask.shape == (width, height) and orientation in _QUARTER_TURNS:
        turns, transpose = _QUARTER_TURNS[orientation]
        stored = mask.T if transpose else mask
        return np.ascontiguousarray(np.rot90(stored, turns))
    raise InputError(
        f"{path}: the mask is {mask.shape[1]}x{mask.shape[0]} px but its photo is {width}x{height} "
        "px; make the mask again at the photo's size"
    )
