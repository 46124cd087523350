"""A view's photo as it lies on disk: its size must be that of its camera."""

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.files import read_rgb_as_stored
from r3gw.importing.source import SourceView


def stored_size(view: SourceView) -> tuple[int, int]:
    """Width and height of the photo on disk, in px, as its camera states them."""
    camera = view.camera if view.lens is None else view.lens
    return int(camera.width), int(camera.height)


def stored_photo(view: SourceView) -> NDArray[np.uint8]:
    """The photo ``[H, W, 3]``, distorted as it was taken.

    Raises:
        InputError: If it is unreadable or not of its camera's size.
    """
    photo = read_rgb_as_stored(view.photo)
    width, height = stored_size(view)
    if photo.shape[:2] != (height, width):
        raise InputError(
            f"{view.photo}: the photo is {photo.shape[1]}x{photo.shape[0]} px but its camera is "
            f"{width}x{height} px; import the photos that the model was made from"
        )
    return photo
