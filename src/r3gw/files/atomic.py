"""Atomic writes: a file appears whole under its name, or not at all.

Whole means: every byte was taken by the file system, was forced to the disk, and is counted again
before the file gets its name.
"""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def atomic_path(target: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside ``target`` (same suffix); rename it over ``target`` at the end.

    If the body raises, the temporary file is removed and ``target`` stays as it was. Parent
    folders are made.

    Raises:
        OSError: If the file system refuses; names ``target`` rather than the temporary file.
    """
    target = Path(target)
    temporary = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        _force_to_disk(temporary)
        temporary.replace(target)
    except OSError as error:
        # Python names no file where a write fails, and nobody knows the temporary one.
        if error.errno is None or error.filename not in (None, str(temporary), temporary):
            raise
        raise OSError(error.errno, error.strerror, str(target)) from error
    finally:
        # On a file system that has become read-only, this too would fail.
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def write_bytes(target: str | Path, content: bytes) -> None:
    """Write ``content`` atomically, and count what has arrived before it counts as written.

    Raises:
        OSError: If the file system refuses or keeps less than ``content``.
    """
    with atomic_path(target) as temporary:
        temporary.write_bytes(content)
        if (arrived := temporary.stat().st_size) != len(content):
            raise OSError(f"{target}: only {arrived} of {len(content)} bytes were written")


def write_json(target: str | Path, value: object) -> None:
    """Write ``value`` as indented JSON with sorted keys, atomically; NaN is an error."""
    text = json.dumps(value, indent=2, sort_keys=True, allow_nan=False)
    write_bytes(target, (text + "\n").encode())


def _force_to_disk(path: Path) -> None:
    """Wait until a file's contents are on the disk; late errors of a network disk come up here."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
