"""The mask folder: is_valid/ and is_sky/ hold one PNG per photo, white = True."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.imaging.masks import read_mask
from r3gw.scene import View

Mask = NDArray[np.bool_]

KINDS = ("is_valid", "is_sky")


def load_masks(folder: Path, view: View) -> tuple[Mask, Mask]:
    """Read ``(is_valid, is_sky)``, each ``[H, W]``, of one view from a mask folder.

    Raises:
        InputError: If a mask is missing or of another size than the view's photo.
    """
    is_valid, is_sky = (
        read_mask(folder / kind / f"{view.name}.png", view.width, view.height) for kind in KINDS
    )
    return is_valid, is_sky
