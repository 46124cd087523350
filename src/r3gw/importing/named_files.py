"""Pictures below a folder, and who belongs to whom."""

import os
import unicodedata
from collections.abc import Iterable, Iterator
from pathlib import Path

from r3gw.files import InputError
from r3gw.imaging.files import LDR_SUFFIXES
from r3gw.scene.names import key_of, normalised

# Thumbnails of NAS systems and file managers, trash and resource forks of archives.
_NOT_PHOTOS = {"@eadir", "#recycle", "$recycle.bin", "__macosx", "thumbnails", "lost+found"}


def pictures_below(folder: Path, without: Iterable[str] = ()) -> dict[str, Path]:
    """Pictures below ``folder`` by their normalised path in it; an absent folder has none.

    Args:
        folder: Searched with its subfolders, through symbolic links. Hidden files and folders do
            not count, nor do the thumbnails that NAS systems and file managers keep.
        without: Names of subfolders of ``folder`` to leave out.

    Raises:
        InputError: If a name is not UTF-8, or two differ in their Unicode form alone.
    """
    found: dict[str, Path] = {}
    left_out = {name.lower() for name in without}
    for path in _files(folder, left_out):
        if path.suffix.lower() not in LDR_SUFFIXES or path.name.startswith("."):
            continue
        relative = str(path.relative_to(folder))
        try:
            relative.encode("utf-8")
        except UnicodeEncodeError:
            raise InputError(
                f"{folder}: the file name {relative!a} is not UTF-8 (Latin-1, from an old "
                "archive?); rename the file"
            ) from None
        if (other := found.setdefault(normalised(relative), path)) != path:
            raise InputError(
                f"{path}: has the same name as another file there ({other.name!a}) but for "
                "the Unicode form of its accents; remove one of the two"
            )
    return found


def pictures_by_key(folder: Path, without: Iterable[str] = ()) -> dict[str, Path]:
    """As `pictures_below`, by the key of their path (r3gw.scene.names.key_of).

    Raises:
        InputError: As `pictures_below`, and if two pictures differ in suffix or case alone.
    """
    found: dict[str, Path] = {}
    for name, path in pictures_below(folder, without).items():
        if (other := found.setdefault(key_of(name), path)) != path:
            raise InputError(
                f"{path}: has the same stem as {other.name} in the same folder, so masks and lists "
                "could mean either; rename or remove one of the two"
            )
    return found


def listed(names: Iterable[str], most: int = 5) -> str:
    """The first names, comma separated, and how many more there are."""
    ordered = sorted(names)
    more = f" and {len(ordered) - most} more" if len(ordered) > most else ""
    return ", ".join(ordered[:most]) + more


def _files(folder: Path, left_out: set[str]) -> Iterator[Path]:
    """Files below a folder in order; every folder is entered once, whatever links lead to it."""
    entered: set[tuple[int, int]] = set()
    for place, folders, files in os.walk(folder, followlinks=True):
        here = Path(place)
        status = here.stat()
        if (status.st_dev, status.st_ino) in entered:
            folders.clear()
            continue
        entered.add((status.st_dev, status.st_ino))
        folders[:] = sorted(
            name
            for name in folders
            if not name.startswith(".")
            and unicodedata.normalize("NFC", name).lower() not in _NOT_PHOTOS
            and not (here == folder and name.lower() in left_out)
        )
        yield from (here / name for name in sorted(files) if (here / name).is_file())
