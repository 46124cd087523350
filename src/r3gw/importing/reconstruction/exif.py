"""What a photo's EXIF tells of its camera: the focal length in px and the place, by COLMAP's rules.

COLMAP looks EXIF up in files whose format it reads. HEIC and AVIF are none of them, so for these it
gets a grey JPEG of the photo's size with the photo's EXIF.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pycolmap
from PIL import Image

from r3gw.imaging.decode import Picture


@dataclass(frozen=True)
class Exif:
    """What EXIF tells.

    Attributes:
        focal_px: The focal length, in px, or None.
        place: Latitude and longitude in degrees and altitude in metres, or None.
    """

    focal_px: float | None = None
    place: tuple[float, float, float] | None = None


def read_exif(path: Path, picture: Picture) -> Exif:
    """EXIF of the photo ``path``, which ``picture`` was decoded from."""
    found = _by_colmap(path)
    if found is not None or not picture.exif:
        return found or Exif()
    grey = Image.fromarray(np.full(picture.pixels.shape[:2], 128, np.uint8))
    with tempfile.TemporaryDirectory(prefix="r3gw-") as folder:
        stand_in = Path(folder) / "exif.jpg"
        try:
            grey.save(stand_in, exif=picture.exif)
        except ValueError:  # EXIF that is too long for a JPEG
            return Exif()
        return _by_colmap(stand_in) or Exif()


def _by_colmap(path: Path) -> Exif | None:
    """None if COLMAP does not read the file."""
    try:
        camera = pycolmap.infer_camera_from_image(path)
        bitmap = pycolmap.Bitmap.read(path, as_rgb=False)
    except (ValueError, RuntimeError):
        return None
    focal = float(camera.mean_focal_length()) if camera.has_prior_focal_length else None
    if bitmap is None:
        return Exif(focal)
    latitude, longitude = bitmap.exif_latitude(), bitmap.exif_longitude()
    if latitude is None or longitude is None or (latitude == longitude == 0):
        return Exif(focal)
    altitude = float(bitmap.exif_altitude() or 0.0)
    return Exif(focal, (float(latitude), float(longitude), altitude))
