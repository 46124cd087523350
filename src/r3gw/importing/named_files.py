"""Files matched by stem: photos, masks and lists name the same view with different endings."""

from collections.abc import Iterable
from pathlib import Path, PurePosixPath

from r3gw.files import InputError
from r3gw.imaging.files import LDR_SUFFIXES


def key_of(name: str) -> str:
    """The key under which files of one view meet: the stem in lower case."""
    stem = PurePosixPath(name.replace("\\", "/")).name
    return (stem.rpartition(".")[0] or stem).lower()


def pictures_by_key(folder: Path, without: Iterable[str] = ()) -> dict[str, Path]:
    """Pictures below ``folder`` by their key; an absent folder has none.

    Args:
        folder: Searched with its subfolders; hidden files do not count.
        without: Names of subfolders to leave out.

    Raises:
        InputError: If two pictures share a stem.
    """
    found: dict[str, Path] = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() not in LDR_SUFFIXES or path.name.startswith("."):
            continue
        if any(path.is_relative_to(folder / name) for name in without):
            continue
        if (other := found.setdefault(key_of(path.name), path)) != path:
            raise InputError(
                f"{path}: has the same stem as {other.name}, but views are told apart by stem; "
                "rename or remove one of the two"
            )
    return found


def listed(names: Iterable[str], most: int = 5) -> str:
    """The first names, comma separated, and how many more there are."""
    ordered = sorted(names)
    more = f" and {len(ordered) - most} more" if len(ordered) > most else ""
    return ", ".join(ordered[:most]) + more
