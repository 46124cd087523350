"""Photos as structure from motion gets them: upright, in order, with what masks allow.

Files are called by their number, because lists of pairs cannot hold blanks and because folders may
hold equal stems; `PreparedPhoto.path` says which photo it is.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pycolmap
from numpy.typing import NDArray
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.imaging.files import read_rgb, write_image
from r3gw.importing.folders import Masks, masks_of
from r3gw.importing.orientation import upright_mask
from r3gw.importing.reconstruction.panorama import is_panorama
from r3gw.importing.source import MaskKind, SourceMask


@dataclass(frozen=True)
class PreparedPhoto:
    """One photo in the working folder.

    Attributes:
        path: The photo's path below the folder of photos.
        file: The upright picture, without EXIF.
        focal_px: The focal length that EXIF tells, in px.
        place: Latitude and longitude in degrees and altitude in metres that EXIF tells.
        masks: Upright masks, white = True.
    """

    path: str
    file: Path
    focal_px: float | None
    place: tuple[float, float, float] | None
    masks: Mapping[MaskKind, SourceMask]


def prepared_photos(
    photos: Mapping[str, Path], masks: Masks, folder: Path
) -> tuple[PreparedPhoto, ...]:
    """Write every photo upright to ``folder/photos`` and what may be used of it to ``folder/keep``.

    Args:
        photos: Photos by their path below their folder.
        masks: Their masks, of the size of the upright or of the stored photo.
        folder: The working folder.

    Raises:
        InputError: If a photo or mask is unreadable, a mask is of another size, or a photo shows
            all directions.
    """
    has_masks = any(list(files) for files in masks.values())
    prepared = []
    ordered = sorted(photos, key=_natural)
    for number, path in enumerate(tqdm(ordered, desc="reading photos", unit="photo", leave=False)):
        pixels = read_rgb(photos[path])
        if is_panorama(photos[path], pixels):
            raise InputError(
                f"{photos[path]}: is a 360-degree picture or a panorama, which no pinhole camera "
                "takes; split it into cube faces, or take it out of the folder"
            )
        file = folder / "photos" / f"{number:06d}.png"
        write_image(file, pixels)
        upright = _upright_masks(masks_of(masks, path), photos[path], folder / "masks", file.name)
        if has_masks:
            # pycolmap leaves out photos without a mask, so every photo gets one.
            write_image(folder / "keep" / f"{file.name}.png", _usable(pixels, upright))
        kept = {kind: SourceMask(mask) for kind, (mask, _) in upright.items()}
        prepared.append(PreparedPhoto(path, file, *_exif(photos[path]), kept))
    return tuple(prepared)


def _natural(path: str) -> list[tuple[int, str]]:
    """Order in which people count: ``frame_2`` before ``frame_10``."""
    parts = re.split(r"(\d+)", path.lower())
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


def _upright_masks(
    masks: Mapping[MaskKind, SourceMask], photo: Path, folder: Path, name: str
) -> dict[MaskKind, tuple[Path, NDArray[np.bool_]]]:
    upright: dict[MaskKind, tuple[Path, NDArray[np.bool_]]] = {}
    for kind, mask in masks.items():
        values = upright_mask(mask.path, photo)
        values = values if mask.white_means else ~values
        write_image(folder / kind / name, values)
        upright[kind] = folder / kind / name, values
    return upright


def _usable(
    pixels: NDArray[np.uint8], masks: Mapping[MaskKind, tuple[Path, NDArray[np.bool_]]]
) -> NDArray[np.bool_]:
    """Where features may be taken from."""
    keep: NDArray[np.bool_] = np.ones(pixels.shape[:2], dtype=np.bool_)
    for kind, (_, mask) in masks.items():
        keep &= ~mask if kind == "is_sky" else mask
    return keep


def _exif(photo: Path) -> tuple[float | None, tuple[float, float, float] | None]:
    """Focal length in px and place, as far as EXIF tells them."""
    try:
        camera = pycolmap.infer_camera_from_image(photo)
        bitmap = pycolmap.Bitmap.read(photo, as_rgb=False)
    except (ValueError, RuntimeError):  # a format that pycolmap does not read
        return None, None
    focal = float(camera.mean_focal_length()) if camera.has_prior_focal_length else None
    if bitmap is None:
        return focal, None
    latitude, longitude = bitmap.exif_latitude(), bitmap.exif_longitude()
    if latitude is None or longitude is None or (latitude == longitude == 0):
        return focal, None
    return focal, (float(latitude), float(longitude), float(bitmap.exif_altitude() or 0.0))


def focal_lengths(photos: Sequence[PreparedPhoto]) -> dict[str, float]:
    """Focal lengths that EXIF tells, in px, by file name."""
    return {photo.file.name: photo.focal_px for photo in photos if photo.focal_px is not None}
