"""OpenEXR pictures: which channels mean RGB, and reading and writing them as float32.

A layer with R, G and B (or red, green and blue, in any case) is a colour picture; one with Y, but
without X, Z or chroma, is a grey one. Channels without a layer's name come before layers, and the
layer that Blender calls Combined comes before its other passes. Alpha and all other channels are
passed over, and where several layers could be meant, the file is refused.
"""

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from r3gw.files import InputError, write_bytes
from r3gw.imaging.formats import MOST_BYTES, MOST_PIXELS

_FLAT = (OpenEXR.scanlineimage, OpenEXR.tiledimage)
_MOST_CHANNELS = 1024
_COLOURS = (("r", "g", "b"), ("red", "green", "blue"))
_GREY = "y"
_NO_GREY = {"ry", "by", "x", "z"}  # beside Y: chroma, or the axes of a vector
_WHOLE_PICTURE = "combined"  # Blender's pass that the others are parts of


@dataclass(frozen=True)
class _Layer:
    """A set of channels that makes a picture.

    Attributes:
        part: Number of the part that holds it.
        name: Of the layer, with a dot behind; empty for plain R, G, B or Y.
        channels: Names of its red, green and blue, or of its grey.
    """

    part: int
    name: str
    channels: tuple[str, ...]


def read_exr(path: Path) -> NDArray[np.float32]:
    """Read the RGB or grey picture of an EXR file as ``[H, W, 3]``, in its display window.

    Raises:
        InputError: If the file is missing, damaged, too large, deep, or its channels have no or
            more than one meaning as RGB.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such picture")
    if path.stat().st_size > MOST_BYTES:
        raise InputError(f"{path}: is larger than {MOST_BYTES >> 20} MiB; scale the map down")
    data = path.read_bytes()
    headers = _opened(data, path, header_only=True).parts
    for part in headers:
        _check_header(part.header, path)
    layer = _chosen(headers, path)
    parts = _opened(data, path, header_only=False).parts
    if len(parts) != len(headers):  # OpenEXR passes over parts whose pixels are damaged
        raise InputError(
            f"{path}: not a readable EXR picture (its pixels are damaged or cut off); copy it again"
        )
    part = parts[layer.part]
    planes = []
    for name in layer.channels:
        pixels = np.asarray(part.channels[name].pixels, dtype=np.float32)
        planes.append(_in_display_window(pixels, part.header))
    return np.ascontiguousarray(np.stack(planes * (3 // len(planes)), axis=-1))


def write_exr(path: Path, image: NDArray[np.float32]) -> None:
    """Write linear float32 RGB ``[H, W, 3]`` as a 32-bit EXR, atomically."""
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    stream = io.BytesIO()
    OpenEXR.File(header, {"RGB": np.ascontiguousarray(image, dtype=np.float32)}).write(stream)
    write_bytes(path, stream.getvalue())


def _opened(data: bytes, path: Path, *, header_only: bool) -> Any:
    try:
        return OpenEXR.File(io.BytesIO(data), separate_channels=True, header_only=header_only)
    except Exception as error:  # OpenEXR raises several unrelated types
        reason = " ".join(str(error).split())[:160]
        raise InputError(f"{path}: not a readable EXR picture ({reason}); save it again") from error


def _check_header(header: dict[str, Any], path: Path) -> None:
    if header.get("type", OpenEXR.scanlineimage) not in _FLAT:
        raise InputError(f"{path}: is a deep EXR picture; flatten it to RGB")
    for window in ("dataWindow", "displayWindow"):
        width, height = _size(header[window])
        if not (width > 0 and height > 0 and width * height <= MOST_PIXELS):
            raise InputError(
                f"{path}: claims {width}x{height} px ({window}), which is no readable picture; "
                f"at most {MOST_PIXELS // 10**6} million pixels are read"
            )
    if len(header["channels"]) > _MOST_CHANNELS:
        raise InputError(f"{path}: has more than {_MOST_CHANNELS} channels; save RGB alone")


def _size(window: tuple[NDArray[np.int32], NDArray[np.int32]]) -> tuple[int, int]:
    low, high = (np.asarray(corner, dtype=np.int64) for corner in window)
    width, height = (high - low + 1).tolist()
    return width, height


def _chosen(parts: list[Any], path: Path) -> _Layer:
    """The one layer that is meant.

    Raises:
        InputError: Naming the channels, if there is none or more than one.
    """
    try:
        names = [[channel.name for channel in part.header["channels"]] for part in parts]
    except UnicodeDecodeError:
        raise InputError(
            f"{path}: not a readable EXR picture (names of its channels); save it again"
        ) from None
    layers = [layer for number, part in enumerate(names) for layer in _layers(number, part)]
    plain = [layer for layer in layers if not layer.name]
    whole = [layer for layer in layers if layer.name.lower().split(".")[-2:-1] == [_WHOLE_PICTURE]]
    for wanted in (plain, whole, layers):
        if len(wanted) == 1:
            _refuse_subsampled(parts[wanted[0].part], wanted[0], path)
            return wanted[0]
        if wanted:
            break
    listed = ", ".join(sorted({name for part in names for name in part})[:12])
    if not layers:
        raise InputError(
            f"{path}: its channels ({listed}) are no RGB picture; save it with channels R, G and B"
        )
    parted = f" in {len(parts)} parts" if len(parts) > 1 else ""
    raise InputError(
        f"{path}: its channels ({listed}{parted}) make {len(layers)} pictures; save the one that "
        "is meant as R, G and B alone"
    )


def _layers(part: int, names: list[str]) -> list[_Layer]:
    prefixes = sorted({name.rpartition(".")[0] for name in names})
    found = []
    for prefix in prefixes:
        start = f"{prefix}." if prefix else ""
        own = {
            name.rpartition(".")[2].lower(): name
            for name in sorted(names, reverse=True)  # so that R comes before r
            if name.rpartition(".")[0] == prefix
        }
        colour = next((wanted for wanted in _COLOURS if set(wanted) <= set(own)), None)
        if colour is not None:
            found.append(_Layer(part, start, tuple(own[letter] for letter in colour)))
        elif _GREY in own and not _NO_GREY & set(own):
            found.append(_Layer(part, start, (own[_GREY],)))
    return found


def _refuse_subsampled(part: Any, layer: _Layer, path: Path) -> None:
    for channel in part.header["channels"]:
        if channel.name in layer.channels and (channel.xSampling, channel.ySampling) != (1, 1):
            raise InputError(f"{path}: its channel {channel.name} is subsampled; save full RGB")


def _in_display_window(pixels: NDArray[np.float32], header: dict[str, Any]) -> NDArray[np.float32]:
    """Pixels of the data window, which may be cropped or too large, at their place; 0 elsewhere."""
    (left, top), _ = header["dataWindow"]
    (from_x, from_y), _ = header["displayWindow"]
    width, height = _size(header["displayWindow"])
    shift_x, shift_y = int(left) - int(from_x), int(top) - int(from_y)
    if (shift_x, shift_y, *pixels.shape) == (0, 0, height, width):
        return pixels
    result = np.zeros((height, width), np.float32)
    rows = slice(max(0, shift_y), max(0, min(height, shift_y + pixels.shape[0])))
    columns = slice(max(0, shift_x), max(0, min(width, shift_x + pixels.shape[1])))
    part = pixels[max(0, -shift_y) :, max(0, -shift_x) :]
    result[rows, columns] = part[: rows.stop - rows.start, : columns.stop - columns.start]
    return result
