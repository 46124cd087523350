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
        raise InputError(f"{source}: {_first_error(error, model, values)}") from None


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
    return f"key '{key}' has the value {value!r}: {first['msg']}"


def _own_keys(loc: tuple[int | str, ...], values: Any) -> list[str]:
    """The keys and numbers of ``loc`` that are in the user's file, and a missing last one.

    What pydantic adds of its own, such as the chosen member of a union, is left out.
    """
    keys = []
    for number, part in enumerate(loc):
        is_there = part in values if isinstance(values, Mapping) else isinstance(part, int)
        if is_there or number == len(loc) - 1:
            keys.append(str(part))
        if is_there and isinstance(values, Mapping | list):
            values = values[part]  # type: ignore[index]
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
