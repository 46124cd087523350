"""Cameras and small pictures of the photos, for the page to jump to and fade to."""

from base64 import b64encode
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.files import read_rgb
from r3gw.scene import View

THUMBNAIL_PX, PICTURE_PX = 96, 480
THUMBNAIL_QUALITY, PICTURE_QUALITY = 70, 72


def photo_record(view: View, folder: Path, *, with_picture: bool) -> dict[str, Any]:
    """What the page knows of one photo (web/src/payload.ts, `Photo`).

    Args:
        view: The photo.
        folder: Of its scene.json; a missing picture file leaves the camera alone.
        with_picture: Whether the larger picture goes along, or the thumbnail alone.
    """
    return {
        "name": view.name,
        "split": view.split,
        "width": view.width,
        "height": view.height,
        "intrinsics": view.intrinsics,
        "camFromWorld": view.cam_from_world,
        **_pictures(folder / view.image, with_picture),
    }


def _pictures(path: Path, with_picture: bool) -> dict[str, str | None]:
    try:
        pixels = read_rgb(path)
    except InputError:
        return {"thumbnail": None, "picture": None}
    picture = _webp(pixels, PICTURE_PX, PICTURE_QUALITY) if with_picture else None
    return {"thumbnail": _webp(pixels, THUMBNAIL_PX, THUMBNAIL_QUALITY), "picture": picture}


def _webp(pixels: NDArray[np.uint8], longest_px: int, quality: int) -> str:
    height, width = pixels.shape[:2]
    scale = min(1.0, longest_px / max(height, width))
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    small = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    bgr = cv2.cvtColor(small, cv2.COLOR_RGB2BGR)
    done, encoded = cv2.imencode(".webp", bgr, [cv2.IMWRITE_WEBP_QUALITY, quality])
    if not done:
        raise OSError("could not encode a picture as WebP")
    return "data:image/webp;base64," + b64encode(encoded.tobytes()).decode()
