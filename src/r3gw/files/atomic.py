"""Atomic writes: a file appears whole under its name, or not at all."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic_path(target: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside ``target`` (same suffix); rename it over ``target`` at the end.

    If the body raises, the temporary file is removed and ``target`` stays as it was. Parent
    folders are made.
    """
    target = Path(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        yield temporary
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def write_json(target: str | Path, value: object) -> None:
    """Write ``value`` as indented JSON with sorted keys, atomically; NaN is an error."""
    text = json.dumps(value, indent=2, sort_keys=True, allow_nan=False)
    with atomic_path(target) as path:
        path.write_text(text + "\n")
