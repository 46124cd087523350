"""Image files as the project uses them: 8-bit pictures and linear float pictures, RGB order.

How formats are decoded is known by r3gw.imaging.decode, exr and radiance. Every error names the
file.
"""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError, write_bytes
from r3gw.imaging.decode import Picture, eight_bits, read_picture
from r3gw.imaging.exr import read_exr, write_exr
from r3gw.imaging.formats import HDR_SUFFIXES, LDR_SUFFIXES, WRITTEN_SUFFIXES
from r3gw.imaging.radiance import read_radiance

__all__ = [
    "HDR_SUFFIXES",
    "LDR_SUFFIXES",
    "WRITTEN_SUFFIXES",
    "read_grey",
    "read_labels",
    "read_linear",
    "read_rgb",
    "read_rgb_as_stored",
    "rgb_of",
    "write_exr",
    "write_image",
]

_JPEG_OPTIONS = (
    cv2.IMWRITE_JPEG_QUALITY,
    95,
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
)


def read_rgb(path: Path) -> NDArray[np.uint8]:
    """Read a picture as 8-bit RGB ``[H, W, 3]``; EXIF orientation is applied, alpha dropped.

    Raises:
        InputError: If the file is missing, truncated or no picture.
    """
    return rgb_of(read_picture(path).upright(), path)


def read_rgb_as_stored(path: Path) -> NDArray[np.uint8]:
    """Read a picture as 8-bit RGB ``[H, W, 3]`` in the order of its pixels on disk.

    EXIF orientation is not applied: COLMAP's cameras describe the stored pixels.

    Raises:
        InputError: If the file is missing, truncated or no picture.
    """
    return rgb_of(read_picture(path), path)


def rgb_of(picture: Picture, path: Path) -> NDArray[np.uint8]:
    """The 8-bit RGB ``[H, W, 3]`` of a decoded picture; ``path`` is for errors.

    Raises:
        InputError: If it holds float values.
    """
    if picture.pixels.dtype == np.float32:
        raise InputError(
            f"{path}: holds float values; save photos with 8 or 16 bits, and maps of light as EXR"
        )
    pixels = eight_bits(picture.pixels)
    if pixels.ndim == 3:
        return np.ascontiguousarray(pixels)
    return np.ascontiguousarray(np.repeat(pixels[..., None], 3, axis=2))


def read_grey(path: Path) -> NDArray[np.uint8]:
    """Read a picture as 8-bit grey ``[H, W]``, as stored; alpha is dropped.

    Raises:
        InputError: If the file is missing, truncated or no picture.
    """
    pixels = eight_bits(read_picture(path).pixels)
    if pixels.ndim == 2:
        return pixels
    return cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY).astype(np.uint8)


def read_labels(path: Path) -> NDArray[np.uint8]:
    """Read an 8-bit label map: ids ``[H, W]``, or colours as RGB ``[H, W, 3]``.

    Raises:
        InputError: If the file is missing, truncated, no picture or not of 8 bits.
    """
    pixels = read_picture(path).pixels
    if pixels.dtype != np.uint8:
        raise InputError(f"{path}: holds {pixels.dtype} values; save the label map with 8 bits")
    return pixels.astype(np.uint8)


def write_image(path: Path, image: NDArray[np.uint8] | NDArray[np.bool_]) -> None:
    """Write RGB ``[H, W, 3]``, RGBA ``[H, W, 4]``, grey ``[H, W]`` or a mask (True = white).

    The file appears whole or not at all. The format follows the suffix; JPEG uses quality 95
    without chroma subsampling.
    """
    pixels = image.astype(np.uint8) * (255 if image.dtype == np.bool_ else 1)
    if image.ndim == 3:
        code = cv2.COLOR_RGBA2BGRA if image.shape[2] == 4 else cv2.COLOR_RGB2BGR
        pixels = cv2.cvtColor(pixels, code).astype(np.uint8)
    suffix = path.suffix.lower()
    options = () if suffix == ".png" else _JPEG_OPTIONS
    # Encoded in memory and written by Python, which reports a full disk; OpenCV does not.
    done, encoded = cv2.imencode(suffix, pixels, options)
    if not done:
        raise OSError(f"{path}: could not be encoded")
    write_bytes(path, encoded.tobytes())


def read_linear(path: Path) -> NDArray[np.float32]:
    """Read an EXR or Radiance HDR picture as linear float32 ``[H, W, 3]``; grey becomes RGB.

    Raises:
        InputError: If the file is missing, unreadable, has no meaning as RGB, or holds values
            that are not finite.
    """
    image = read_exr(path) if path.suffix.lower() == ".exr" else read_radiance(path)
    is_wrong = ~np.isfinite(image).all(axis=2)
    if is_wrong.any():
        row, column = np.argwhere(is_wrong)[0]
        raise InputError(
            f"{path}: holds NaN or infinite values in {is_wrong.sum()} pixels, the first at column "
            f"{column}, row {row}; repair or replace the picture"
        )
    return image
