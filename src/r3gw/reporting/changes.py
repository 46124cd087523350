"""The settings of runs, and what differs between those of two runs."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from r3gw.files import InputError


@dataclass(frozen=True)
class Change:
    """A setting ``group.key`` and its values in two runs, as text; "absent" where one lacks it."""

    key: str
    before: str
    after: str


def read_settings(run_folder: Path) -> dict[str, Any]:
    """The settings of a run: ``settings.json`` in its folder.

    Raises:
        InputError: If the file is missing or unreadable.
    """
    path = run_folder / "settings.json"
    try:
        settings: dict[str, Any] = json.loads(path.read_text())
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; train the run again") from None
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not readable as JSON ({error}); train the run again") from None
    return settings


def changes(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[Change]:
    """What differs between the settings of two runs, the seed aside, in the settings' order."""
    old, new = dict(_leaves(before)), dict(_leaves(after))
    keys = [key for key in old | new if key != "seed" and old.get(key) != new.get(key)]
    return [Change(key, _as_text(old, key), _as_text(new, key)) for key in keys]


def _leaves(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in settings.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def _as_text(leaves: Mapping[str, Any], key: str) -> str:
    return json.dumps(leaves[key]).strip('"') if key in leaves else "absent"
