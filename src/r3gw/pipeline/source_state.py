"""What a folder of the user's looks like now: the state that decides whether it is read again."""

import hashlib
import os
from collections.abc import Collection, Iterator
from pathlib import Path

_NEVER_DATA = {"thumbs.db", "desktop.ini", "@eadir", "__macosx"}


def source_state(path: Path, without: Collection[Path] = ()) -> str:
    """Digest of the names, sizes and times of everything in a folder, or of one file.

    Symbolic links are followed. What desktops and archives leave beside data does not count: names
    that begin with a dot, thumbnails and the like.

    Args:
        path: Folder or file; one that is missing has a state too.
        without: Folders inside it that do not count, such as this run's own results.
    """
    digest = hashlib.sha256()
    left_out = frozenset(folder.resolve() for folder in without)
    for name, size, time_ns in sorted(_entries(path, "", left_out, frozenset())):
        digest.update(os.fsencode(name) + f"\0{size}\0{time_ns}\n".encode())
    return digest.hexdigest()[:16]


def _entries(
    path: Path, name: str, left_out: frozenset[Path], above: frozenset[Path]
) -> Iterator[tuple[str, int, int]]:
    """Name below the first folder, size and time of every file; a loop of links ends."""
    try:
        status = path.stat()
        if not path.is_dir():
            yield name, status.st_size, status.st_mtime_ns
            return
        folder = path.resolve()
        if folder in above or folder in left_out:
            return
        inside = [entry.name for entry in os.scandir(path)]
    except OSError as error:
        # Missing, a link to nowhere, not to be read: a state too, which ends when that is mended.
        yield f"{name} ({type(error).__name__})", 0, 0
        return
    for each in inside:
        if not each.startswith(".") and each.lower() not in _NEVER_DATA:
            yield from _entries(path / each, f"{name}/{each}", left_out, above | {folder})
