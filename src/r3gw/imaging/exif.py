"""The EXIF block of a picture, and the turn in it that makes the picture upright."""

import warnings
from pathlib import Path
from typing import Any

from PIL import Image

from r3gw.imaging.formats import PILLOW_FORMATS
from r3gw.imaging.heic import decode_heic, is_heic
from r3gw.imaging.orientation import STORED_UPRIGHT

_ORIENTATION_TAG = 0x0112


def read_exif_block(path: Path) -> bytes:
    """The EXIF block of a picture, empty if it has none or none that can be read."""
    try:
        with path.open("rb") as file:
            if is_heic(file.read(256)):
                return decode_heic(path)[1]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of odd metadata, which does not matter here
            with Image.open(path, formats=PILLOW_FORMATS) as image:
                return orientation_and_exif(image)[1]
    except Exception:  # who reads the picture finds the words for it
        return b""


def orientation_and_exif(image: Any) -> tuple[int, bytes]:
    """EXIF's number of the turn, 1 to 8, and the block of a picture that Pillow has opened."""
    try:
        exif = image.getexif()
        number = exif.get(_ORIENTATION_TAG, STORED_UPRIGHT)
        block = exif.tobytes() if len(exif) else b""
    except Exception:  # broken EXIF does not make a photo unreadable, and raises anything
        return STORED_UPRIGHT, b""
    return (number if number in range(1, 9) else STORED_UPRIGHT), block
