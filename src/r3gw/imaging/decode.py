"""Decodes pictures of every format that cameras, phones and editors write, by their contents.

OpenCV decodes JPEG and colours of 16 bits, pi-heif HEIC, Pillow all else. Sizes are checked
before anything is decoded, and whatever a decoder says of a broken file becomes one sentence.
"""

import io
import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from r3gw.files import InputError
from r3gw.imaging.damage import jpeg_is_whole, refuse_altered_png, unread_reason
from r3gw.imaging.exif import orientation_and_exif
from r3gw.imaging.formats import DEVELOP, MOST_BYTES, MOST_PIXELS, PILLOW_FORMATS
from r3gw.imaging.heic import decode_heic, is_heic
from r3gw.imaging.orientation import STORED_UPRIGHT, stored_from_upright, upright_from_stored

_ANIMATED = ("WEBP", "AVIF", "PNG", "GIF")
_TIFF_MAGICS = (b"II*\0", b"MM\0*")
_NEW_SUBFILE_TAG, _DNG_VERSION_TAG = 0x00FE, 0xC612
_RAW_DEPTH = re.compile(r";(\d+)")
_MOST_DEFLATED = 1032  # times its size is all that deflated data can grow to (RFC 1951)
_BROKEN = "not a readable picture (truncated, damaged or of another format?)"
_AGAIN = "copy it again or remove it"

Pixels = NDArray[Any]  # uint8, uint16 or float32


@dataclass(frozen=True)
class Picture:
    """A decoded picture, its pixels in the order in which they are stored.

    Attributes:
        pixels: RGB ``[H, W, 3]`` or grey ``[H, W]``, in the depth of the file.
        alpha: Opacity ``[H, W]`` in the same depth, or None if the file has none.
        orientation: EXIF's number of the turn that makes the picture upright, 1 to 8.
        exif: The EXIF block as bytes, empty if there is none.
    """

    pixels: Pixels
    alpha: Pixels | None
    orientation: int
    exif: bytes = b""

    @property
    def is_opaque(self) -> NDArray[np.bool_] | None:
        """Where it is more than half opaque, ``[H, W]``; None if it is everywhere."""
        if self.alpha is None:
            return None
        is_opaque: NDArray[np.bool_] = eight_bits(self.alpha) >= 128
        return None if is_opaque.all() else is_opaque

    def upright(self) -> "Picture":
        """The same picture as people see it."""
        alpha = None if self.alpha is None else upright_from_stored(self.alpha, self.orientation)
        pixels = upright_from_stored(self.pixels, self.orientation)
        return Picture(pixels, alpha, STORED_UPRIGHT, self.exif)


def read_picture(path: Path) -> Picture:
    """Decode the first or only picture of a file.

    Raises:
        InputError: If the file is missing, truncated, too large, undeveloped sensor data, an
            animation or no picture.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such picture")
    if path.stat().st_size > MOST_BYTES:
        raise InputError(f"{path}: is larger than {MOST_BYTES >> 20} MiB, which no photo is")
    data = path.read_bytes()
    try:
        if is_heic(data):
            return _of_heic(*decode_heic(path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of odd metadata, which does not matter here
            with Image.open(io.BytesIO(data), formats=PILLOW_FORMATS) as image:
                _refuse_unfit(image, path)
                _refuse_hollow_png(image, len(data))
                return _decoded(image, data, path)
    except InputError:
        raise
    except UnidentifiedImageError:
        raise InputError(f"{path}: {_unread(data)}") from None
    except Image.DecompressionBombError:
        raise InputError(
            f"{path}: claims more than {MOST_PIXELS // 10**6} million pixels; scale it down"
        ) from None
    except Exception as error:  # decoders raise a dozen unrelated types on broken files
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{path}: {_BROKEN}: {reason[:120]}; {_AGAIN}") from error


def read_opaque(path: Path) -> NDArray[np.bool_] | None:
    """Where a picture is opaque, ``[H, W]`` as stored; None if it is everywhere.

    A file without an alpha channel is not decoded.

    Raises:
        InputError: As `read_picture`.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path, formats=PILLOW_FORMATS) as image:
                has_alpha = bool(image.has_transparency_data)
    except Exception:  # read_picture finds the words for it
        has_alpha = True
    return read_picture(path).is_opaque if has_alpha else None


def _unread(data: bytes) -> str:
    """Why Pillow does not know a file; OpenCV tells a TIFF of float colours."""
    if data[:4] in _TIFF_MAGICS:
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        if pixels is not None and pixels.dtype.kind == "f":
            return "holds float values; save photos with 8 or 16 bits, and maps of light as EXR"
    return unread_reason(data)


def _of_heic(pixels: NDArray[np.uint8], exif: bytes) -> Picture:
    alpha = pixels[..., 3] if pixels.shape[2] == 4 else None
    return Picture(pixels[..., :3], alpha, STORED_UPRIGHT, exif)


def eight_bits(values: Pixels) -> NDArray[np.uint8]:
    """Values in 8 bits; 65535 becomes 255, and floats must lie in 0 to 1."""
    if values.dtype == np.uint8:
        return np.asarray(values, np.uint8)
    largest = 65535.0 if values.dtype == np.uint16 else 1.0
    scaled = np.clip(values.astype(np.float32) * np.float32(255.0 / largest), 0.0, 255.0)
    rounded: NDArray[np.uint8] = np.rint(scaled).astype(np.uint8)
    return rounded


def _refuse_unfit(image: Any, path: Path) -> None:
    """Refuse by what the header says, before pixels are decoded."""
    width, height = image.size
    if width * height > MOST_PIXELS:
        raise Image.DecompressionBombError
    if image.format == "TIFF":
        tags = image.tag_v2
        if _DNG_VERSION_TAG in tags or tags.get(_NEW_SUBFILE_TAG) == 1:
            raise InputError(f"{path}: is undeveloped (RAW); {DEVELOP}")
    frames = getattr(image, "n_frames", 1)
    if frames > 1 and (image.format in _ANIMATED or _has_equal_pages(image)):
        raise InputError(
            f"{path}: holds {frames} pictures (an animation or pages); save the one that is meant "
            "as PNG, or give a film as MP4"
        )


def _refuse_hollow_png(image: Any, num_bytes: int) -> None:
    """Refuse a PNG that cannot hold the pixels that its header claims; Pillow would fill them in.

    Raises:
        ValueError: If even the best deflated data of this length would be too short.
    """
    if image.format != "PNG" or not image.tile:
        return
    width, height = image.size
    raw_mode = str(image.tile[0][3])
    depth = _RAW_DEPTH.search(raw_mode)
    bits = int(depth.group(1)) if depth else (1 if raw_mode == "1" else 8)
    if width * height * bits * len(image.getbands()) > 8 * _MOST_DEFLATED * num_bytes:
        raise ValueError(f"{num_bytes} bytes cannot hold {width}x{height} px")


def _has_equal_pages(image: Any) -> bool:
    """Whether a TIFF's second page is a picture of its own, no thumbnail."""
    if image.format != "TIFF":
        return False
    size = image.size
    image.seek(1)
    is_equal = bool(image.size == size)
    image.seek(0)
    return is_equal


def _decoded(image: Any, data: bytes, path: Path) -> Picture:
    # Asked first: reading EXIF may decode a PNG, which leaves no tiles.
    has_16_bits = any(";16" in str(tile[3]) for tile in getattr(image, "tile", ()))
    orientation, exif = orientation_and_exif(image)
    if image.format in ("JPEG", "MPO") and image.mode in ("RGB", "L"):
        if not jpeg_is_whole(data):
            raise InputError(f"{path}: {_BROKEN}; {_AGAIN}")
        return Picture(_by_opencv(data, path, image.mode), None, orientation, exif)
    if image.format == "PNG":
        refuse_altered_png(data)
    image.load()
    pixels, alpha = _channels(image)
    if has_16_bits and image.mode in ("RGB", "RGBA", "LA"):
        pixels, alpha = _deep_colours(data, (pixels, alpha))
    picture = Picture(pixels, alpha, orientation, exif)
    if image.format != "TIFF":
        return picture
    # Pillow and OpenCV hand over TIFF upright, unasked.
    alpha = None if alpha is None else stored_from_upright(alpha, orientation)
    return Picture(stored_from_upright(pixels, orientation), alpha, orientation, exif)


def _by_opencv(data: bytes, path: Path, mode: str) -> NDArray[np.uint8]:
    flag = cv2.IMREAD_GRAYSCALE if mode == "L" else cv2.IMREAD_COLOR
    pixels = cv2.imdecode(np.frombuffer(data, np.uint8), flag | cv2.IMREAD_IGNORE_ORIENTATION)
    if pixels is None:
        raise InputError(f"{path}: {_BROKEN}; {_AGAIN}")
    return np.asarray(pixels if mode == "L" else cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB), np.uint8)


def _channels(image: Any) -> tuple[Pixels, Pixels | None]:
    """Colour or grey, and alpha, of a picture that Pillow has decoded."""
    if image.mode.startswith("I") or image.mode == "F":
        values = np.asarray(image)
        if image.mode == "F":
            return values.astype(np.float32), None
        if values.min() < 0 or values.max() > 65535:
            raise ValueError("whole numbers that 16 bits cannot hold")
        return values.astype(np.uint16), None
    if image.mode in ("1", "L"):
        return np.asarray(image.convert("L"), np.uint8), None
    if image.mode in ("LA", "La"):
        both = np.asarray(image.convert("LA"), np.uint8)
        return both[..., 0], both[..., 1]
    if image.has_transparency_data:
        four = np.asarray(image.convert("RGBA"), np.uint8)
        return four[..., :3], four[..., 3]
    return np.asarray(image.convert("RGB"), np.uint8), None


def _deep_colours(
    data: bytes, shallow: tuple[Pixels, Pixels | None]
) -> tuple[Pixels, Pixels | None]:
    """All 16 bits of colours, of which Pillow keeps 8; ``shallow`` where OpenCV cannot."""
    values = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if values is None or values.dtype != np.uint16 or values.shape[:2] != shallow[0].shape[:2]:
        return shallow
    if values.ndim == 2:
        return values.astype(np.uint16), None
    rgb = values[..., 2::-1].astype(np.uint16)
    return rgb, values[..., 3].astype(np.uint16) if values.shape[2] == 4 else None
