"""Photos as structure from motion gets them: upright, in order, with what masks allow.

Files are called by their number, because lists of pairs cannot hold blanks and because folders may
hold equal stems; `PreparedPhoto.path` says which photo it is.
"""

import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.imaging.decode import read_picture
from r3gw.imaging.files import rgb_of, write_image
from r3gw.importing.folders import Masks, masks_of
from r3gw.importing.reconstruction.exif import focal_length_px, place_deg
from r3gw.importing.reconstruction.orientation import upright_mask
from r3gw.importing.reconstruction.panorama import is_panorama
from r3gw.importing.source import MaskKind, SourceMask


@dataclass(frozen=True)
class PreparedPhoto:
    """One photo in the working folder.

    Attributes:
        path: The photo's path below the folder of photos.
        file: The upright picture, without EXIF.
        focal_px: The focal length that EXIF tells, in px.
        place: Latitude and longitude in degrees that EXIF tells.
        masks: Upright masks, white = True.
    """

    path: str
    file: Path
    focal_px: float | None
    place: tuple[float, float] | None
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
    prepared, is_masked = [], False
    ordered = sorted(photos, key=_natural)
    for number, path in enumerate(tqdm(ordered, desc="reading photos", unit="photo", leave=False)):
        stored = read_picture(photos[path])
        upright = stored.upright()
        pixels, keep = rgb_of(upright, photos[path]), upright.is_opaque
        if is_panorama(photos[path], pixels):
            raise InputError(
                f"{photos[path]}: is a 360-degree picture or a panorama, which no pinhole camera "
                "takes; split it into cube faces, or take it out of the folder"
            )
        if keep is None:
            keep = np.ones(pixels.shape[:2], np.bool_)
        else:
            pixels = np.concatenate([pixels, keep[..., None] * np.uint8(255)], axis=2)
        file = folder / "photos" / f"{number:06d}.png"
        write_image(file, pixels)
        kept = {}
        for kind, mask in masks_of(masks, path).items():
            read = upright_mask(mask.path, stored)
            values = read.is_white if mask.white_means else ~read.is_white
            write_image(folder / "masks" / kind / file.name, values)
            kept[kind] = SourceMask(folder / "masks" / kind / file.name, levels=read.described())
            keep = keep & (~values if kind == "is_sky" else values)
        # pycolmap leaves out photos without a mask, so every photo gets one.
        write_image(folder / "keep" / f"{file.name}.png", keep)
        is_masked = is_masked or not keep.all()
        focal, place = focal_length_px(stored), place_deg(stored)
        prepared.append(PreparedPhoto(path, file, focal, place, kept))
    if not is_masked:
        shutil.rmtree(folder / "keep")
    return tuple(prepared)


def _natural(path: str) -> list[tuple[int, str]]:
    """Order in which people count: ``frame_2`` before ``frame_10``."""
    parts = re.split(r"(\d+)", path.lower())
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


def focal_lengths(photos: Sequence[PreparedPhoto]) -> dict[str, float]:
    """Focal lengths that EXIF tells, in px, by file name."""
    return {photo.file.name: photo.focal_px for photo in photos if photo.focal_px is not None}
