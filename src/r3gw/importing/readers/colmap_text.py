"""COLMAP's text model files: cameras.txt, images.txt, points3D.txt."""

from collections.abc import Iterator
from pathlib import Path

from r3gw.files import InputError
from r3gw.importing.lens import Lens, lens_models
from r3gw.importing.readers.colmap_records import Numbers, StoredImage, StoredModel, ordered_points

_IMAGE_WORDS = 10  # id, quaternion, translation, camera, name


def read_text(folder: Path) -> StoredModel:
    """Read the three ``.txt`` files of ``folder``.

    Raises:
        InputError: If one is no text in UTF-8 or a line is not what the format says.
    """
    cameras, images, points = (folder / f"{n}.txt" for n in ("cameras", "images", "points3D"))
    lenses = dict(_camera(cameras, number, line) for number, line in _filled(cameras))
    found = dict(_point(points, number, line) for number, line in _filled(points))
    return StoredModel(lenses, list(_images(images)), *ordered_points(found))


def count_images(path: Path) -> int:
    """How many images an images.txt holds.

    Raises:
        InputError: As `read_text`.
    """
    return sum(1 for _ in _images(path))


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Number and text of every line that is no comment."""
    for number, line in enumerate(path.read_bytes().split(b"\n"), start=1):
        try:
            text = line.decode("utf-8-sig" if number == 1 else "utf-8").strip()
        except UnicodeDecodeError:
            raise InputError(
                f"{path}: line {number} is not text in UTF-8 (a photo's name in Latin-1?); save "
                "the file as UTF-8, or rename the photo and make the model again"
            ) from None
        if not text.startswith("#"):
            yield number, text


def _filled(path: Path) -> Iterator[tuple[int, str]]:
    return ((number, line) for number, line in _lines(path) if line)


def _camera(path: Path, number: int, line: str) -> tuple[int, Lens]:
    words = line.split()
    names = {name for name, _ in lens_models().values()}
    if len(words) < 5 or words[1] not in names:
        raise _wrong(path, number, "CAMERA_ID MODEL WIDTH HEIGHT PARAMS")
    try:
        parameters = tuple(float(word) for word in words[4:])
        return int(words[0]), Lens(words[1], int(words[2]), int(words[3]), parameters)
    except ValueError:
        raise _wrong(path, number, "CAMERA_ID MODEL WIDTH HEIGHT PARAMS") from None


def _images(path: Path) -> Iterator[StoredImage]:
    """Every image; its line of points is passed over, and may be missing altogether."""
    points_may_follow = False
    for number, line in _lines(path):
        image = _image(line)
        if image is not None:
            yield image
            points_may_follow = True
        elif points_may_follow and _are_points(line):
            points_may_follow = False
        elif line:
            raise _wrong(path, number, "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME")


def _image(line: str) -> StoredImage | None:
    """The image of a line, or None if the line is something else; a name may hold blanks."""
    words = line.split(maxsplit=_IMAGE_WORDS - 1)
    if len(words) < _IMAGE_WORDS or not _is_id(words[0]) or not _is_id(words[8]):
        return None
    values = _numbers(words[1:8])
    if values is None or _are_points(line):
        return None
    return StoredImage(words[9], values[:4], values[4:], int(words[8]))


def _are_points(line: str) -> bool:
    """Whether a line holds nothing but triples of numbers (X Y POINT3D_ID), or none."""
    words = line.split()
    return len(words) % 3 == 0 and _numbers(words) is not None


def _point(path: Path, number: int, line: str) -> tuple[int, Numbers]:
    words = line.split(maxsplit=7)
    values = _numbers(words[1:7])
    if len(words) < 7 or not _is_id(words[0]) or values is None:
        raise _wrong(path, number, "POINT3D_ID X Y Z R G B ERROR TRACK")
    return int(words[0]), values


def _is_id(word: str) -> bool:
    return word.isdecimal() and len(word) < 20  # of 64 bits


def _numbers(words: list[str]) -> Numbers | None:
    try:
        return tuple(float(word) for word in words)
    except ValueError:
        return None


def _wrong(path: Path, number: int, expected: str) -> InputError:
    return InputError(f"{path}: line {number} is damaged, it must be '{expected}'; copy it again")
