"""Radiance pictures (.hdr, .pic): RGBE pixels in every orientation and run-length encoding.

G. Ward, "Real Pixels", Graphics Gems II, 1991, and the format's description in Radiance's file
formats document: a text header, one line with size and orientation, then scanlines that are flat,
have the old repeats (1 1 1 count) or, from 8 to 32767 pixels, each component's runs by itself.
The header's EXPOSURE is not divided out, which OpenCV and the common viewers do not do either.
"""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.formats import MOST_BYTES, MOST_PIXELS

_MAGIC = b"#?"  # with the name of the program or format: RADIANCE, RGBE, AUTOPANO, ...
_SIZE = re.compile(rb"([+-])([XY]) +(\d{1,6}) +([+-])([XY]) +(\d{1,6})\s*$")
_LONGEST_HEADER = 65536
_ADAPTIVE_WIDTHS = range(8, 32768)


class _BrokenError(ValueError):
    """What is wrong with a file's bytes."""


def read_radiance(path: Path) -> NDArray[np.float32]:
    """Read a Radiance picture as linear ``[H, W, 3]``, upright.

    Raises:
        InputError: If the file is missing, damaged, too large or in CIE XYZ.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such picture")
    if path.stat().st_size > MOST_BYTES:
        raise InputError(f"{path}: is larger than {MOST_BYTES >> 20} MiB; scale the map down")
    data = path.read_bytes()
    try:
        size, start = _header(data)
        lines, length = int(size.group(3)), int(size.group(6))
        if lines * length > MOST_PIXELS:
            raise _BrokenError(f"claims {lines}x{length} pixels")
        rgbe = _scanlines(data, start, lines, length)
    except _BrokenError as error:
        raise InputError(
            f"{path}: not a readable Radiance picture ({error}); save it again, as EXR if need be"
        ) from None
    return _upright(_linear(rgbe), size)


def _header(data: bytes) -> tuple["re.Match[bytes]", int]:
    """The line of sizes, and where the pixels begin."""
    if not data.startswith(_MAGIC):
        raise _BrokenError("it does not begin with #?RADIANCE")
    position = 0
    while (end := data.find(b"\n", position, _LONGEST_HEADER)) >= 0:
        line = data[position:end]
        position = end + 1
        if line.startswith(b"FORMAT=") and line[7:].strip() != b"32-bit_rle_rgbe":
            raise _BrokenError(f"its pixels are {line[7:60].decode(errors='replace').strip()}")
        size = _SIZE.match(line)
        if size is not None:
            if size.group(2) == size.group(5) or not int(size.group(3)) * int(size.group(6)):
                break
            return size, position
    raise _BrokenError("it has no line of sizes such as -Y 512 +X 1024")


def _scanlines(data: bytes, start: int, lines: int, length: int) -> NDArray[np.uint8]:
    """RGBE ``[lines, length, 4]`` in the order of the file."""
    # The shortest scanline is made of the longest runs: this bounds what is set aside.
    if lines * length > 255 * 4 * max(1, len(data) - start):
        raise _BrokenError("it is cut off")
    result = np.empty((lines, length, 4), np.uint8)
    position = start
    for number in range(lines):
        mark = data[position : position + 4]
        if length in _ADAPTIVE_WIDTHS and mark[:2] == b"\x02\x02" and mark[2:3] < b"\x80":
            if int.from_bytes(mark[2:4], "big") != length:
                raise _BrokenError(f"scanline {number} has another length than {length}")
            position = _adaptive_scanline(data, position + 4, result[number])
        else:
            position = _old_scanline(data, position, result[number])
    return result


def _adaptive_scanline(data: bytes, position: int, line: NDArray[np.uint8]) -> int:
    for component in range(4):
        values = bytearray()
        while len(values) < len(line):
            if position + 1 >= len(data):
                raise _BrokenError("it is cut off")
            count = data[position]
            if count > 128:
                values += data[position + 1 : position + 2] * (count - 128)
                position += 2
            elif count:
                values += data[position + 1 : position + 1 + count]
                position += 1 + count
            else:
                raise _BrokenError("it has an empty run")
        if len(values) != len(line) or position > len(data):
            raise _BrokenError("a run leaves its scanline")
        line[:, component] = np.frombuffer(values, np.uint8)
    return position


def _old_scanline(data: bytes, position: int, line: NDArray[np.uint8]) -> int:
    """Flat pixels, where 1 1 1 n repeats the one before n times (n shifted by repeats in a row)."""
    flat = np.frombuffer(data[position : position + 4 * len(line)], np.uint8)
    if len(flat) == 4 * len(line) and not (flat.reshape(-1, 4)[:, :3] == 1).all(axis=1).any():
        line[:] = flat.reshape(-1, 4)
        return position + len(flat)
    filled, shift = 0, 0
    while filled < len(line):
        pixel = data[position : position + 4]
        position += 4
        if len(pixel) < 4:
            raise _BrokenError("it is cut off")
        if pixel[:3] != b"\x01\x01\x01":
            line[filled] = np.frombuffer(pixel, np.uint8)
            filled, shift = filled + 1, 0
            continue
        count = pixel[3] << shift
        if not filled or filled + count > len(line) or shift > 16:
            raise _BrokenError("a run leaves its scanline")
        line[filled : filled + count] = line[filled - 1]
        filled, shift = filled + count, shift + 8
    return position


def _linear(rgbe: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Mantissas times 2^(exponent - 136); exponent 0 is black."""
    exponent = rgbe[..., 3].astype(np.int32)
    scale = np.where(exponent > 0, np.ldexp(np.float32(1.0), exponent - 136), np.float32(0.0))
    return (rgbe[..., :3] * scale[..., None]).astype(np.float32)


def _upright(pixels: NDArray[np.float32], size: "re.Match[bytes]") -> NDArray[np.float32]:
    """From the file's order to rows from top to bottom; its y axis points up."""
    first_sign, first_axis, _, second_sign, _, _ = size.groups()
    if first_axis == b"X":
        pixels, first_sign, second_sign = pixels.swapaxes(0, 1), second_sign, first_sign
    if first_sign == b"+":
        pixels = pixels[::-1]
    if second_sign == b"-":
        pixels = pixels[:, ::-1]
    return np.ascontiguousarray(pixels)
