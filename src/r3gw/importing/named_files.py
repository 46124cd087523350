"""Pictures below a folder, and who belongs to whom."""

import os
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path

from r3gw.files import InputError
from r3gw.imaging.formats import DEVELOP, is_picture, is_raw
from r3gw.scene.names import key_of, normalised

# Thumbnails of NAS systems and file managers, trash and resource forks of archives.
_NOT_PHOTOS = {"@eadir", "#recycle", "$recycle.bin", "__macosx", "thumbnails", "lost+found"}

UNDEVELOPED = "RAW, not developed"


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
    for path in files_below(folder, left_out):
        if not is_picture(path):
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


def other_files(folder: Path, without: Iterable[str] = ()) -> dict[str, str]:
    """Files below ``folder`` that are not read as pictures, by path, and why not.

    Args:
        folder: Searched as `pictures_below` searches it.
        without: Names of subfolders of ``folder`` to leave out.
    """
    found = {}
    developed = {key_of(name) for name in pictures_below(folder, without)}
    for path in _entries(folder, {name.lower() for name in without}):
        name = str(path.relative_to(folder)).encode(errors="replace").decode()
        if path.name.startswith(".") or (is_picture(path) and path.is_file()):
            continue
        if is_raw(path):
            is_double = key_of(name) in developed
            found[name] = "RAW beside its developed picture" if is_double else UNDEVELOPED
        elif path.is_symlink() and not path.exists():
            found[name] = "a link that leads nowhere"
        else:
            found[name] = f"no picture ({path.suffix.lower() or 'without suffix'})"
    return found


def refuse_undeveloped(folder: Path, others: Mapping[str, str]) -> None:
    """Refuse RAW files that nobody has developed; what `other_files` found is looked at.

    Raises:
        InputError: Naming them and the remedy.
    """
    raw = [name for name, reason in others.items() if reason == UNDEVELOPED]
    if raw:
        files = "one RAW file is" if len(raw) == 1 else f"{len(raw)} RAW files are"
        raise InputError(
            f"{folder}: {files} among the photos ({listed(raw)}); {DEVELOP}, or take it out of the "
            "folder"
        )


def notes_on(others: Mapping[str, str]) -> tuple[str, ...]:
    """A sentence about what `other_files` found, if it found anything."""
    if not others:
        return ()
    counts = Counter(others.values())
    kinds = [f"{count} {reason}" for reason, count in sorted(counts.items())]
    files = "one file" if len(others) == 1 else f"{len(others)} files"
    return (f"{files} beside the photos not read: {', '.join(kinds)}; {listed(others)}",)


def files_below(folder: Path, left_out: Collection[str] = ()) -> Iterator[Path]:
    """Files below a folder in order, as `pictures_below` searches it, hidden ones left out.

    Args:
        folder: Searched with its subfolders, through symbolic links.
        left_out: Names of subfolders of ``folder``, in lower case, to leave out.
    """
    return (
        path
        for path in _entries(folder, left_out)
        if path.is_file() and not path.name.startswith(".")
    )


def _entries(folder: Path, left_out: Collection[str]) -> Iterator[Path]:
    """All but folders below a folder; every folder is entered once, whatever links lead to it."""
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
        yield from (here / name for name in sorted(files))
