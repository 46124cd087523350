"""The focal length that a photo's EXIF tells, in px, by COLMAP's own rules."""

import tempfile
from pathlib import Path

import numpy as np
import pycolmap
from PIL import Image

from r3gw.imaging.decode import Picture


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
