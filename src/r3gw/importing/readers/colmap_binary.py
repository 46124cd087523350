"""COLMAP's binary model files: cameras.bin, images.bin, points3D.bin (little endian)."""

import struct
from pathlib import Path

from r3gw.files import InputError
from r3gw.importing.lens import Lens, lens_models
from r3gw.importing.readers.colmap_records import Numbers, StoredImage, StoredModel, ordered_points

_COUNT = struct.Struct("<Q")
_CAMERA = struct.Struct("<IiQQ")  # id, model, width, height; the parameters follow
_POSE = struct.Struct("<I4d3dI")  # id, quaternion, translation, camera; name and points follow
_POINT2D_BYTES = 2 * 8 + 8
_POINT3D = struct.Struct("<Q3d3BdQ")  # id, position, colour, error, track length; the track follows
_TRACK_BYTES = 4 + 4


def read_binary(folder: Path) -> StoredModel:
    """Read the three ``.bin`` files of ``folder``.

    Raises:
        InputError: If one is cut off, or holds an unknown camera model or an unreadable name.
    """
    cameras = _Cursor(folder / "cameras.bin")
    lenses = dict(_camera(cameras) for _ in range(cameras.count(_CAMERA.size)))
    images = _Cursor(folder / "images.bin")
    stored = [_image(images) for _ in range(images.count(_POSE.size))]
    points = _Cursor(folder / "points3D.bin")
    found = dict(_point(points) for _ in range(points.count(_POINT3D.size)))
    return StoredModel(lenses, stored, *ordered_points(found))


def count_images(path: Path) -> int:
    """How many images an images.bin announces.

    Raises:
        InputError: If the file is cut off.
    """
    return _Cursor(path).count(_POSE.size)


class _Cursor:
    """A position in a file's bytes."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.data = path.read_bytes()
        self.position = 0

    def count(self, least_bytes: int) -> int:
        """Read how many elements follow, each of which takes ``least_bytes`` or more."""
        (count,) = self.unpack(_COUNT)
        if count * least_bytes > len(self.data) - self.position:
            raise self.damaged()
        return int(count)

    def unpack(self, layout: struct.Struct) -> Numbers:
        """Read the next values."""
        start = self.position
        self.skip(layout.size)
        return layout.unpack_from(self.data, start)

    def skip(self, num_bytes: int) -> None:
        """Go past the next bytes."""
        self.position += num_bytes
        if self.position > len(self.data):
            raise self.damaged()

    def text(self) -> str:
        """Read a zero-terminated name."""
        end = self.data.find(b"\0", self.position)
        if end < 0:
            raise self.damaged()
        name, self.position = self.data[self.position : end], end + 1
        try:
            return name.decode("utf-8")
        except UnicodeDecodeError:
            raise InputError(
                f"{self.path}: the image name {ascii(name)[1:]} is not UTF-8; rename the photo "
                "and make the model again"
            ) from None

    def damaged(self) -> InputError:
        """What to say of a file that ends too early."""
        return InputError(
            f"{self.path}: the file is damaged or cut off ({len(self.data)} bytes); copy it again"
        )


def _camera(cursor: _Cursor) -> tuple[int, Lens]:
    identifier, model, width, height = (int(value) for value in cursor.unpack(_CAMERA))
    if model not in lens_models():
        raise InputError(
            f"{cursor.path}: camera {identifier} has the model number {model}, which COLMAP does "
            "not have; copy the file again"
        )
    name, count = lens_models()[model]
    parameters = cursor.unpack(struct.Struct(f"<{count}d"))
    return identifier, Lens(name, width, height, tuple(float(value) for value in parameters))


def _image(cursor: _Cursor) -> StoredImage:
    _, *pose, camera_id = cursor.unpack(_POSE)
    name = cursor.text()
    cursor.skip(_POINT2D_BYTES * cursor.count(_POINT2D_BYTES))
    return StoredImage(name, tuple(pose[:4]), tuple(pose[4:]), int(camera_id))


def _point(cursor: _Cursor) -> tuple[int, Numbers]:
    identifier, *values, _, track_length = cursor.unpack(_POINT3D)
    cursor.skip(_TRACK_BYTES * int(track_length))
    return int(identifier), tuple(values)
