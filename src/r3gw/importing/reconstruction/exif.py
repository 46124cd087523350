"""What a photo's EXIF tells of its camera: the focal length, and where it was taken."""

import struct
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pycolmap
from PIL import Image

from r3gw.imaging.decode import Picture

_GPS = 0x8825  # EXIF 2.32, 4.6.6: the tags' numbers within it follow
_LATITUDE_REF, _LATITUDE, _LONGITUDE_REF, _LONGITUDE = 1, 2, 3, 4


def focal_length_px(picture: Picture) -> float | None:
    """The focal length of a photo, in px, or None if its EXIF tells none.

    COLMAP looks EXIF up in files whose format it reads, which HEIC and AVIF are not: it gets a
    grey JPEG of the photo's size with the photo's EXIF.
    """
    if not picture.exif:
        return None
    height, width = picture.pixels.shape[:2]
    with tempfile.TemporaryDirectory(prefix="r3gw-") as folder:
        path = Path(folder) / "exif.jpg"
        grey = Image.fromarray(np.full((height, width), 128, np.uint8))
        try:
            grey.save(path, exif=picture.exif)
        except ValueError:  # EXIF that is too long for a JPEG
            return None
        camera = pycolmap.infer_camera_from_image(path)
    return float(camera.mean_focal_length()) if camera.has_prior_focal_length else None


def place_deg(picture: Picture) -> tuple[float, float] | None:
    """Latitude and longitude at which a photo was taken, in degrees, or None if EXIF tells none.

    Zero in both is what cameras write before their receiver knows anything.
    """
    if not picture.exif:
        return None
    exif = Image.Exif()
    try:
        exif.load(picture.exif)
        tags = exif.get_ifd(_GPS)
        latitude = _degrees(tags[_LATITUDE]) * (-1 if tags.get(_LATITUDE_REF) == "S" else 1)
        longitude = _degrees(tags[_LONGITUDE]) * (-1 if tags.get(_LONGITUDE_REF) == "W" else 1)
    except (KeyError, TypeError, ValueError, ZeroDivisionError, SyntaxError, struct.error):
        return None
    if not (abs(latitude) <= 90 and abs(longitude) <= 180) or latitude == longitude == 0:
        return None
    return latitude, longitude


def _degrees(parts: Sequence[Any]) -> float:
    """Degrees, minutes and seconds as one number."""
    degrees, minutes, seconds = (float(part) for part in parts)
    return degrees + minutes / 60 + seconds / 3600
