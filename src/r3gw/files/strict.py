"""Pydantic base class and one-sentence errors for everything read from configuration files."""

from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from r3gw.files import InputError


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
        raise InputError(f"{source}: {_first_error(error, model)}") from None


def read_yaml(path: Path) -> dict[str, Any]:
    """Read a YAML mapping.

    Raises:
        InputError: If the file is missing, not YAML, or not a mapping.
    """
    try:
        content = yaml.safe_load(path.read_text())
    except FileNotFoundError:
        raise InputError(f"{path}: no such settings file") from None
    except yaml.YAMLError as error:
        raise InputError(f"{path}: not readable as YAML ({' '.join(str(error).split())})") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected a mapping of settings, got {type(content).__name__}")
    return content


def _first_error(error: ValidationError, model: type[BaseModel]) -> str:
    # A misspelt key is also a missing one: the misspelling says more.
    errors = error.errors()
    first = next((e for e in errors if e["type"] == "extra_forbidden"), errors[0])
    key = ".".join(str(part) for part in first["loc"]) or "(whole file)"
    if first["type"] == "extra_forbidden":
        wrong = str(first["loc"][-1])
        # The key may be right elsewhere: `study.seed`, where `seeds` is meant.
        near = get_close_matches(wrong, _all_keys(model) - {wrong}, n=1, cutoff=0.6)
        hint = f"; did you mean '{near[0]}'?" if near else "; remove it or see config/README.md"
        return f"unknown key '{key}'{hint}"
    if first["type"] == "missing":
        return f"key '{key}' is missing; see config/README.md"
    return f"key '{key}' has the value {first['input']!r}: {first['msg']}"


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
