"""test_config.py of a NeRF-OSR scene: how each test view is lit and masked."""

from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from pydantic import ValidationError

from r3gw.files import InputError
from r3gw.imaging.files import HDR_SUFFIXES, LDR_SUFFIXES, read_linear, read_rgb
from r3gw.importing.literal_file import read_literals
from r3gw.importing.named_files import files_below
from r3gw.scene import EvaluationEntry
from r3gw.scene.names import key_of, stem_of

_REQUIRED = ("env_map_path", "initial_env_map_rotation", "env_map_scaling", "sun_angles")


def read_evaluation(folder: Path) -> dict[str, EvaluationEntry]:
    """Entries of ``folder/test_config.py`` by the name of their view; {} if there is no such file.

    Paths in the entries are resolved by file name inside ``folder``, since those in the file are
    the author's own.

    Raises:
        InputError: If the file holds more than data, lacks or mistypes a value, names a file that
            is not in ``folder``, or an environment map is not 2:1.
    """
    path = folder / "test_config.py"
    if not path.exists():
        return {}
    entries: dict[str, EvaluationEntry] = {}
    seen: set[str] = set()
    for name, values in _views(read_literals(path)):
        if key_of(name) in seen:
            raise InputError(f"{path}: has two entries for '{name}'; keep one")
        seen.add(key_of(name))
        entries[name] = _entry(path, name, values)
    if not entries:
        raise InputError(f"{path}: has no entry with an env_map_path; it must have one per view")
    return entries


def missing_evaluation_files(folder: Path) -> list[str]:
    """Names of the files that ``folder/test_config.py`` names but ``folder`` does not hold.

    Raises:
        InputError: If test_config.py is there but holds more than data.
    """
    path = folder / "test_config.py"
    if not path.exists():
        return []
    written = [
        str(values[key])
        for _, values in _views(read_literals(path))
        for key in ("mask_path", "env_map_path")
        if values.get(key) is not None
    ]
    return [name for name in written if not _same_name(folder, PurePosixPath(_posix(name)))]


def evaluated_views(folder: Path) -> set[str]:
    """Stems, in lower case, of the views that ``folder/test_config.py`` has an entry for.

    Raises:
        InputError: If test_config.py is there but holds more than data.
    """
    path = folder / "test_config.py"
    return {stem_of(n).lower() for n, _ in _views(read_literals(path))} if path.exists() else set()


def _views(values: Mapping[Any, Any]) -> Iterator[tuple[str, Mapping[Any, Any]]]:
    """Every nested dict that has an ``env_map_path``, with its key."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            if "env_map_path" in value:
                yield str(name), value
            else:
                yield from _views(value)


def _entry(path: Path, name: str, values: Mapping[Any, Any]) -> EvaluationEntry:
    for key in _REQUIRED:
        if key not in values:
            raise InputError(f"{path}: view '{name}' lacks '{key}'; add it")
    rotation = _parts(path, name, values, "initial_env_map_rotation", ("x", "y", "z"))
    scaling = _parts(path, name, values, "env_map_scaling", ("threshold", "scale"))
    env_map = _resolve(path.parent, values["env_map_path"], name)
    _check_two_to_one(env_map)
    mask = values.get("mask_path")
    try:
        return EvaluationEntry(
            mask=None if mask is None else str(_resolve(path.parent, mask, name)),
            env_map=str(env_map),
            rotation_rad=rotation,
            threshold=scaling[0],
            scale=scaling[1],
            sun_angles_rad=values["sun_angles"],
        )
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{path}: view '{name}', {key}: {first['msg']}") from None


def _parts(
    path: Path, name: str, values: Mapping[Any, Any], key: str, parts: tuple[str, ...]
) -> tuple[Any, ...]:
    """The named parts of a dict entry; a list is taken in the same order."""
    value = values[key]
    if isinstance(value, list) and len(value) == len(parts):
        return tuple(value)
    if isinstance(value, Mapping) and set(parts) <= set(value):
        return tuple(value[part] for part in parts)
    raise InputError(f"{path}: view '{name}', '{key}' must give {', '.join(parts)}")


def _resolve(folder: Path, written: object, view: str) -> Path:
    """The file below ``folder`` that shares its name and most parent folders with ``written``."""
    wanted = PurePosixPath(_posix(str(written)))
    parents = [part.lower() for part in wanted.parts[:-1]]
    found = _same_name(folder, wanted)
    if not found:
        raise InputError(
            f"{folder}: view '{view}' of test_config.py names {wanted.name}, which is not there; "
            "put the file in place"
        )
    scores = [_shared_parents(path.relative_to(folder), parents) for path in found]
    best = [path for path, score in zip(found, scores, strict=True) if score == max(scores)]
    if len(best) > 1:
        raise InputError(
            f"{folder}: view '{view}' of test_config.py names {wanted}, which fits {best[0]} and "
            f"{best[1]}; keep one"
        )
    return best[0]


def _posix(written: str) -> str:
    return written.replace("\\", "/")


def _same_name(folder: Path, wanted: PurePosixPath) -> list[Path]:
    """Pictures below ``folder`` with the stem of ``wanted``."""
    return [
        path
        for path in files_below(folder)
        if path.suffix.lower() in LDR_SUFFIXES + HDR_SUFFIXES
        and key_of(path.name) == key_of(wanted.name)
    ]


def _shared_parents(path: Path, parents: list[str]) -> int:
    own = [part.lower() for part in path.parts[:-1]]
    count = 0
    while count < min(len(own), len(parents)) and own[-1 - count] == parents[-1 - count]:
        count += 1
    return count


def _check_two_to_one(path: Path) -> None:
    image = read_linear(path) if path.suffix.lower() in HDR_SUFFIXES else read_rgb(path)
    height, width = image.shape[:2]
    if width != 2 * height:
        raise InputError(
            f"{path}: the environment map is {width}x{height} px; an equirectangular map must be "
            "twice as wide as high"
        )
