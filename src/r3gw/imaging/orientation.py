"""EXIF orientation (EXIF 2.32, tag 0x0112): turns between a picture as stored and as seen."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

STORED_UPRIGHT = 1
# Number of quarter turns to the left after an optional transposition, from stored to upright.
_TURNS = {1: (0, False), 3: (2, False), 5: (0, True), 6: (3, False), 7: (2, True), 8: (1, False)}
_MIRRORED = {2: 1, 4: 0}  # orientation: the axis that is flipped

Value = TypeVar("Value", bound=np.generic)


def upright_from_stored(pixels: NDArray[Value], orientation: int) -> NDArray[Value]:
    """Turn a picture ``[H, W, ...]`` as EXIF's ``orientation`` (1 to 8) says."""
    if orientation in _MIRRORED:
        return np.ascontiguousarray(np.flip(pixels, _MIRRORED[orientation]))
    turns, transpose = _TURNS[orientation]
    return np.ascontiguousarray(np.rot90(_transposed(pixels, transpose), turns))


def stored_from_upright(pixels: NDArray[Value], orientation: int) -> NDArray[Value]:
    """Undo `upright_from_stored`."""
    if orientation in _MIRRORED:
        return np.ascontiguousarray(np.flip(pixels, _MIRRORED[orientation]))
    turns, transpose = _TURNS[orientation]
    return np.ascontiguousarray(_transposed(np.rot90(pixels, -turns), transpose))


def _transposed(pixels: NDArray[Value], transpose: bool) -> NDArray[Value]:
    return pixels.swapaxes(0, 1) if transpose else pixels
