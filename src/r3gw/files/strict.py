"""Pydantic base class and one-sentence errors for everything read from configuration files."""

import json
from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from r3gw.files import InputError

MOST_BYTES = 1 << 28
_MOST_VALUES = 50_000_000
_LONGEST_VALUE = 120  # characters of a wrong value in a sentence


class Strict(BaseModel):
    """Frozen settings; unknown keys and non-finite numbers are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


Settings = TypeVar("Settings", bound=Strict)


def validated(model: type[Settings], values: Mapping[str, Any], source: str) -> Settings:
    """Build ``model`` from ``values``.

    Raises:
        InputError: One sentence with the first wrong key, its value and what is expected;
            ``source`` names the file.
    """
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise InputError(f"{source}: {_first_error(error, model, values)}") from None


def read_yaml(path: Path) -> dict[str, Any]:
    """Read a mapping of settings from YAML, or from JSON if the file is called ``.json``.

    Raises:
        InputError: If the file is missing, too large, no text in UTF-8, not YAML or JSON, or not a
            mapping.
    """
    text = _text(path, "settings file")
    try:
        content = json.loads(text) if path.suffix == ".json" else yaml.safe_load(text)
        _require_bounded(content)
    except (yaml.YAMLError, ValueError, RecursionError, OverflowError) as error:
        kind = "JSON" if path.suffix == ".json" else "YAML"
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(f"{path}: not readable as {kind} ({reason})") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected a mapping of settings, got {type(content).__name__}")
    return content


def read_json(path: Path) -> dict[str, Any]:
    """Read a JSON object that r3gw itself has written.

    Raises:
        InputError: If the file is missing, too large, damaged or not an object.
    """
    try:
        content = json.loads(_text(path, "file"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not readable as JSON ({error})") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected a JSON object, got {type(content).__name__}")
    return content


def _text(path: Path, what: str) -> str:
    if not path.is_file():
        raise InputError(f"{path}: no such {what}")
    if path.stat().st_size > MOST_BYTES:
        raise InputError(f"{path}: is larger than {MOST_BYTES >> 20} MiB, which no {what} is")
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: is not text in UTF-8 (byte {error.start}); save it as UTF-8"
        ) from None


def _require_bounded(content: object) -> None:
    """Refuse a tree that aliases (``&a``, ``*a``) make endless or far larger than the file.

    Raises:
        ValueError: If its aliases lead in a circle or stand for too many values.
    """
    sizes: dict[int, int | None] = {}

    def size(value: object) -> int:
        if not isinstance(value, dict | list):
            return 1
        known = sizes.get(id(value), 0)
        if known is None:
            raise ValueError("its aliases lead in a circle")
        if known:
            return known
        sizes[id(value)] = None
        parts = value.values() if isinstance(value, dict) else value
        sizes[id(value)] = total = 1 + sum(size(part) for part in parts)
        if total > _MOST_VALUES:
            raise ValueError(f"it stands for more than {_MOST_VALUES} values")
        return total

    size(content)


def _first_error(error: ValidationError, model: type[BaseModel], values: Mapping[str, Any]) -> str:
    # A misspelt key is also a missing one: the misspelling says more.
    errors = error.errors()
    first = next((e for e in errors if e["type"] == "extra_forbidden"), errors[0])
    kind, loc, value = first["type"], first["loc"], first["input"]
    if kind.startswith("union_tag"):
        # The key that says which settings these are: missing, or with an unknown value.
        tag = str(first["ctx"]["discriminator"]).strip("'")
        kind = "missing" if kind == "union_tag_not_found" else kind
        loc, value = (*loc, tag), value.get(tag) if isinstance(value, Mapping) else value
    key = ".".join(_own_keys(loc, values)) or "(whole file)"
    if kind == "extra_forbidden":
        wrong = str(first["loc"][-1])
        # The key may be right elsewhere: `study.seed`, where `seeds` is meant.
        near = get_close_matches(wrong, _all_keys(model) - {wrong}, n=1, cutoff=0.6)
        hint = f"; did you mean '{near[0]}'?" if near else "; remove it or see config/README.md"
        return f"unknown key '{key}'{hint}"
    if kind == "missing":
        return f"key '{key}' is missing; see config/README.md"
    written = repr(value)
    written = written if len(written) <= _LONGEST_VALUE else f"{written[:_LONGEST_VALUE]}..."
    return f"key '{key}' has the value {written}: {' '.join(first['msg'].split())}"


def _own_keys(loc: tuple[int | str, ...], values: Any) -> list[str]:
    """The keys and numbers of ``loc`` that are in the user's file, and a missing last one.

    What pydantic adds of its own, such as the chosen member of a union, is left out.
    """
    keys = []
    for number, part in enumerate(loc):
        if isinstance(values, list):
            is_there = isinstance(part, int) and part < len(values)
        else:
            is_there = isinstance(values, Mapping) and part in values
        if is_there or number == len(loc) - 1:
            keys.append(str(part))
        if is_there:
            values = values[part]
    return keys


def _all_keys(model: type[BaseModel]) -> set[str]:
    keys: set[str] = set()
    pending: list[Any] = [model]
    while pending:
        current = pending.pop()
        if isinstance(current, type) and issubclass(current, BaseModel):
            keys |= set(current.model_fields)
            pending += [field.annotation for field in current.model_fields.values()]
        else:
            pending += getattr(current, "__args__", ())
    return keys
