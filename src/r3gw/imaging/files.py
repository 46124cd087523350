"""Image files: 8-bit pictures (PNG, JPEG) and linear float pictures (EXR, HDR), RGB order.

OpenCV reads and writes; EXR goes through the OpenEXR package. Every error names the file.
"""

from pathlib import Path

import cv2
import numpy as np
import OpenEXR
from numpy.typing import NDArray

from r3gw.files import InputError, atomic_path

LDR_SUFFIXES = (".png", ".jpg", ".jpeg")
HDR_SUFFIXES = (".exr", ".hdr")


def read_rgb(path: Path) -> NDArray[np.uint8]:
    """Read an 8-bit picture as RGB ``[H, W, 3]``; EXIF orientation is applied.

    Raises:
        InputError: If the file is missing, truncated or no picture.
    """
    return cv2.cvtColor(_read(path, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB).astype(np.uint8)


def read_rgb_as_stored(path: Path) -> NDArray[np.uint8]:
    """Read an 8-bit picture as RGB ``[H, W, 3]`` in the order of its pixels on disk.

    EXIF orientation is not applied: COLMAP's cameras describe the stored pixels.

    Raises:
        InputError: If the file is missing, truncated or no picture.
    """
    bgr = _read(path, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    return cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB).astype(np.uint8)


def read_grey(path: Path) -> NDArray[np.uint8]:
    """Read an 8-bit picture as grey ``[H, W]``.

    Raises:
        InputError: If the file is missing, truncated or no picture.
    """
    return _read(path, cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION).astype(np.uint8)


def read_labels(path: Path) -> NDArray[np.uint8]:
    """Read an 8-bit label map: ids ``[H, W]``, or colours as RGB ``[H, W, 3]``.

    Raises:
        InputError: If the file is missing, truncated, no picture or not of 8 bits.
    """
    pixels = _read(path, cv2.IMREAD_UNCHANGED)
    if pixels.dtype != np.uint8:
        raise InputError(f"{path}: holds {pixels.dtype} values; save the label map with 8 bits")
    if pixels.ndim == 2:
        return pixels.astype(np.uint8)
    return cv2.cvtColor(pixels[..., :3], cv2.COLOR_BGR2RGB).astype(np.uint8)


def write_image(path: Path, image: NDArray[np.uint8] | NDArray[np.bool_]) -> None:
    """Write RGB ``[H, W, 3]``, grey ``[H, W]`` or a mask (True = white), atomically.

    The format follows the suffix; JPEG uses quality 95 without chroma subsampling.
    """
    pixels = image.astype(np.uint8) * (255 if image.dtype == np.bool_ else 1)
    if image.ndim == 3:
        pixels = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR).astype(np.uint8)
    jpeg = [
        cv2.IMWRITE_JPEG_QUALITY,
        95,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    ]
    with atomic_path(path) as temporary:
        if not cv2.imwrite(str(temporary), pixels, jpeg if path.suffix != ".png" else []):
            raise OSError(f"could not write {path}")


def read_linear(path: Path) -> NDArray[np.float32]:
    """Read an EXR or Radiance HDR picture as linear float32 ``[H, W, 3]``.

    Raises:
        InputError: If the file is missing, unreadable or holds values that are not finite.
    """
    if path.suffix.lower() == ".exr":
        if not path.is_file():
            raise InputError(f"{path}: no such picture")
        try:
            channels = OpenEXR.File(str(path)).channels()
        except Exception as error:  # OpenEXR raises several unrelated types
            raise InputError(f"{path}: not a readable EXR picture ({error})") from error
        pixels = channels["RGB"].pixels if "RGB" in channels else channels["RGBA"].pixels[..., :3]
        image = np.asarray(pixels, dtype=np.float32)
    else:
        bgr = _read(path, cv2.IMREAD_ANYDEPTH | cv2.IMREAD_COLOR)
        image = cv2.cvtColor(bgr.astype(np.float32), cv2.COLOR_BGR2RGB).astype(np.float32)
    if not np.isfinite(image).all():
        raise InputError(f"{path}: holds NaN or infinite values; repair or replace the picture")
    return image


def write_exr(path: Path, image: NDArray[np.float32]) -> None:
    """Write linear float32 RGB ``[H, W, 3]`` as a 32-bit EXR, atomically."""
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with atomic_path(path) as temporary:
        channels = {"RGB": np.ascontiguousarray(image, dtype=np.float32)}
        OpenEXR.File(header, channels).write(str(temporary))


def _read(path: Path, flags: int) -> NDArray[np.integer] | NDArray[np.floating]:
    if not path.is_file():
        raise InputError(f"{path}: no such picture")
    image = cv2.imread(str(path), flags)
    if image is None or not _jpeg_is_whole(path):
        raise InputError(f"{path}: not a readable picture (truncated or of another format?)")
    return np.asarray(image)  # type: ignore[return-value]


def _jpeg_is_whole(path: Path) -> bool:
    """Whether a JPEG reaches its end marker; OpenCV fills a cut-off one with grey, without a word.

    Walks the segments to the start of the scan (ITU T.81, Annex B), so that neither a thumbnail
    before it nor data appended behind the picture counts. Other formats are whole here.
    """
    data = path.read_bytes()
    if data[:2] != b"\xff\xd8":
        return True
    position = 2
    while data[position : position + 2] not in (b"\xff\xda", b""):
        filler = data[position : position + 2] == b"\xff\xff"
        length = int.from_bytes(data[position + 2 : position + 4], "big")
        position += 1 if filler else 2 + length
    return data.find(b"\xff\xd9", position) >= 0
