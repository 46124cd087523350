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
from numpy.typing import NDArray
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.imaging.decode import Picture, read_picture
from r3gw.imaging.files import rgb_of, write_image
from r3gw.importing.folders import Masks, masks_of
from r3gw.importing.reconstruction.exif import read_exif
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
        place: Latitude and longitude in degrees and altitude in metres that EXIF tells.
        masks: Upright masks, white = True.
        exif: The EXIF of the photo itself, empty if there is none.
    """

    path: str
    file: Path
    focal_px: float | None
    place: tuple[float, float, float] | None
    masks: Mapping[MaskKind, SourceMask]
    exif: bytes = b""


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
    keep_folder, is_masked = folder / "keep", False
    prepared = []
    ordered = sorted(photos, key=_natural)
    for number, path in enumerate(tqdm(ordered, desc="reading photos", unit="photo", leave=False)):
        picture = read_picture(photos[path])
        upright = picture.upright()
        pixels = rgb_of(upright, photos[path])
        if is_panorama(photos[path], pixels):
            raise InputError(
                f"{photos[path]}: is a 360-degree picture or a panorama, which no pinhole camera "
                "takes; split it into cube faces, or take it out of the folder"
            )
        file = folder / "photos" / f"{number:06d}.png"
        baked = _upright_masks(masks_of(masks, path), picture, folder / "masks", file.name)
        keep = _usable(upright, baked)
        write_image(file, _with_alpha(pixels, upright.is_opaque))
        # pycolmap leaves out photos without a mask, so every photo gets one.
        write_image(keep_folder / f"{file.name}.png", keep)
        is_masked = is_masked or not keep.all()
        exif = read_exif(photos[path], picture)
        kept = {kind: mask for kind, (mask, _) in baked.items()}
        prepared.append(PreparedPhoto(path, file, exif.focal_px, exif.place, kept, picture.exif))
    if not is_masked:
        shutil.rmtree(keep_folder, ignore_errors=True)
    return tuple(prepared)


def _natural(path: str) -> list[tuple[int, str]]:
    """Order in which people count: ``frame_2`` before ``frame_10``."""
    parts = re.split(r"(\d+)", path.lower())
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


Baked = dict[MaskKind, tuple[SourceMask, NDArray[np.bool_]]]


def _upright_masks(
    masks: Mapping[MaskKind, SourceMask], photo: Picture, folder: Path, name: str
) -> Baked:
    upright: Baked = {}
    for kind, mask in masks.items():
        read = upright_mask(mask.path, photo)
        values = read.is_white if mask.white_means else ~read.is_white
        write_image(folder / kind / name, values)
        upright[kind] = SourceMask(folder / kind / name, levels=read.described()), values
    return upright


def _usable(upright: Picture, masks: Baked) -> NDArray[np.bool_]:
    """Where features may be taken from."""
    keep: NDArray[np.bool_] = np.ones(upright.pixels.shape[:2], dtype=np.bool_)
    if (is_opaque := upright.is_opaque) is not None:
        keep &= is_opaque
    for kind, (_, mask) in masks.items():
        keep &= ~mask if kind == "is_sky" else mask
    return keep


def _with_alpha(
    pixels: NDArray[np.uint8], is_opaque: NDArray[np.bool_] | None
) -> NDArray[np.uint8]:
    """RGB, or RGBA where parts of the photo are transparent."""
    if is_opaque is None:
        return pixels
    return np.concatenate([pixels, is_opaque[..., None] * np.uint8(255)], axis=2)


def focal_lengths(photos: Sequence[PreparedPhoto]) -> dict[str, float]:
    """Focal lengths that EXIF tells, in px, by file name."""
    return {photo.file.name: photo.focal_px for photo in photos if photo.focal_px is not None}
