"""Files of named tensors with a JSON record: safetensors, which holds data and never code.

The record is one metadata entry, so that equal content gives equal bytes (the format's library
orders several entries by chance).
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import safetensors
from safetensors.torch import save
from torch import Tensor

from r3gw.files.atomic import atomic_path
from r3gw.files.errors import InputError

KEY = "r3gw"
LARGEST_BYTES = 8 * 10**9  # About 50 million Gaussians with shadows.


def write_arrays(path: Path, tensors: Mapping[str, Tensor], record: Mapping[str, Any]) -> None:
    """Write tensors and a record of plain values, atomically; NaN stands as such in the record."""
    content = {name: tensor.detach().contiguous() for name, tensor in tensors.items()}
    packed = save(content, {KEY: json.dumps(record, sort_keys=True)})
    with atomic_path(path) as temporary:
        temporary.write_bytes(packed)


def read_arrays(path: Path, what: str) -> tuple[dict[str, Tensor], dict[str, Any]]:
    """Read what `write_arrays` wrote.

    Args:
        path: The file.
        what: What it should be, for the sentence: "model of r3gw".

    Raises:
        InputError: If the file is too large, damaged, or not written by r3gw.
    """
    with _opened(path, what) as file:
        # A copy, since the file is mapped: who cuts it short later must not end this process.
        tensors = {name: file.get_tensor(name).clone() for name in file.keys()}  # noqa: SIM118
        return tensors, _record(file, path, what)


def read_record(path: Path, what: str) -> dict[str, Any]:
    """The record alone; as `read_arrays`."""
    with _opened(path, what) as file:
        return _record(file, path, what)


@contextmanager
def _opened(path: Path, what: str) -> Iterator[Any]:
    require_size(path, LARGEST_BYTES)
    try:
        with safetensors.safe_open(path, framework="pt") as file:
            yield file
    except InputError:
        raise
    except (safetensors.SafetensorError, OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: damaged, or no {what} ({_first_line(error)})") from None


def _record(file: Any, path: Path, what: str) -> dict[str, Any]:
    text = (file.metadata() or {}).get(KEY)
    if text is None:
        raise InputError(f"{path}: no {what}: it lacks the record '{KEY}'")
    record = json.loads(text)
    if not isinstance(record, dict):
        raise InputError(f"{path}: no {what}: its record is no mapping")
    return record


def require_size(path: Path, largest: int) -> None:
    """Refuse a file that is larger than ``largest`` bytes.

    Raises:
        InputError: If it is, or if there is no such file.
    """
    try:
        size = path.stat().st_size
    except OSError as error:
        raise InputError(f"{path}: not readable ({error.strerror})") from None
    if size > largest:
        raise InputError(
            f"{path}: {size / 1e9:.1f} GB, more than the {largest / 1e9:.1f} GB that are read"
        )


def _first_line(error: Exception) -> str:
    return str(error).split("\n")[0][:120] or type(error).__name__
