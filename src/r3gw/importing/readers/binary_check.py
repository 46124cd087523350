"""Are COLMAP's binary files whole? A truncated file would end pycolmap's process or read as 0.

Only lengths are walked here, by COLMAP's documented format; pycolmap reads the contents.
"""

from collections.abc import Callable
from pathlib import Path

import pycolmap

from r3gw.files import InputError

_CAMERA_BYTES = 4 + 4 + 8 + 8  # id, model, width, height; 8 per parameter follow
_POSE_BYTES = 4 + 7 * 8 + 4  # id, quaternion and translation, camera; name and points follow
_POINT2D_BYTES = 2 * 8 + 8
_POINT3D_BYTES = 8 + 3 * 8 + 3 + 8  # id, position, colour, error; the track follows
_TRACK_BYTES = 4 + 4


def check_whole(folder: Path) -> None:
    """Walk cameras.bin, images.bin and points3D.bin.

    Raises:
        InputError: If one ends before the elements that it announces.
    """
    walkers: dict[str, Callable[[_Cursor], None]] = {
        "cameras": _camera,
        "images": _image,
        "points3D": _point,
    }
    for name, walk in walkers.items():
        path = folder / f"{name}.bin"
        cursor = _Cursor(path.read_bytes())
        try:
            for _ in range(cursor.count()):
                walk(cursor)
        except _EndedError:
            raise InputError(
                f"{path}: the file is damaged or cut off ({len(cursor.data)} bytes); copy it again"
            ) from None


class _EndedError(Exception):
    """The file is shorter than its contents."""


class _Cursor:
    """A position in a file's bytes."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.position = 0

    def skip(self, num_bytes: int) -> bytes:
        """Return the next bytes and go past them."""
        start, self.position = self.position, self.position + num_bytes
        if self.position > len(self.data):
            raise _EndedError
        return self.data[start : self.position]

    def count(self) -> int:
        """Read a 64-bit count."""
        return int.from_bytes(self.skip(8), "little")

    def skip_text(self) -> None:
        """Go past a zero-terminated name."""
        end = self.data.find(b"\0", self.position)
        if end < 0:
            raise _EndedError
        self.position = end + 1


def _camera(cursor: _Cursor) -> None:
    model = int.from_bytes(cursor.skip(_CAMERA_BYTES)[4:8], "little")
    try:
        identifier = pycolmap.CameraModelId(model)
    except ValueError:
        raise _EndedError from None
    example = pycolmap.Camera.create_from_model_id(1, identifier, 1.0, 1, 1)
    cursor.skip(8 * len(example.params))


def _image(cursor: _Cursor) -> None:
    cursor.skip(_POSE_BYTES)
    cursor.skip_text()
    cursor.skip(_POINT2D_BYTES * cursor.count())


def _point(cursor: _Cursor) -> None:
    cursor.skip(_POINT3D_BYTES)
    cursor.skip(_TRACK_BYTES * cursor.count())
