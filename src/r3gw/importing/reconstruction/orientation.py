"""EXIF orientation: masks turned as their photos are."""

from dataclasses import replace
from pathlib import Path

from r3gw.files import InputError
from r3gw.imaging.decode import Picture
from r3gw.imaging.masks import MaskLevels, read_mask_levels
from r3gw.imaging.orientation import upright_from_stored


def upright_mask(path: Path, photo: Picture) -> MaskLevels:
    """A photo's mask ``[H, W]``, True where white, of the size of the photo as people see it.

    A mask of that size is taken as it is. One of the size of the stored pixels, where EXIF swaps
    width and height, is turned as EXIF says.

    Args:
        path: The mask.
        photo: Its photo as stored.

    Raises:
        InputError: If the mask is unreadable or of another size.
    """
    mask = read_mask_levels(path)
    stored = photo.pixels.shape[:2]
    seen = photo.upright().pixels.shape[:2]
    if mask.is_white.shape == seen:
        return mask
    if mask.is_white.shape == stored:
        return replace(mask, is_white=upright_from_stored(mask.is_white, photo.orientation))
    height, width = mask.is_white.shape
    raise InputError(
        f"{path}: the mask is {width}x{height} px but its photo is {seen[1]}x{seen[0]} px; make "
        "the mask again at the photo's size"
    )
