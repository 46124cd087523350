"""NumPy archives (``.npz``) of arrays of known names, types and shapes, read without trust."""

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from r3gw.files.atomic import atomic_path
from r3gw.files.errors import InputError

MOST_BYTES = 8 * 10**9  # unpacked; about 500 million points


@dataclass(frozen=True)
class Array:
    """What an array must be.

    Attributes:
        dtype: Its type.
        shape: Its sides; None is any length.
    """

    dtype: type[np.generic]
    shape: tuple[int | None, ...]

    def fits(self, values: NDArray[Any]) -> bool:
        """Whether an array has this type and shape, and is finite."""
        sides = zip(values.shape, self.shape, strict=False)
        return (
            values.dtype == np.dtype(self.dtype)
            and values.ndim == len(self.shape)
            and all(wanted in (None, side) for side, wanted in sides)
            and (values.dtype.kind != "f" or bool(np.isfinite(values).all()))
        )


def write_npz(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays atomically, unpacked."""
    with atomic_path(path) as temporary, temporary.open("wb") as stream:
        np.savez(stream, allow_pickle=False, **arrays)


def read_npz(path: Path, wanted: Mapping[str, Array], remedy: str) -> dict[str, NDArray[Any]]:
    """Read the arrays that ``wanted`` names.

    Args:
        path: The archive.
        wanted: What it must hold; other arrays are passed over.
        remedy: What to do about a missing or damaged file, such as "import the scene again".

    Raises:
        InputError: If the file is missing, damaged, too large, or lacks an array of this type and
            shape with finite values.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file; {remedy}")
    try:
        with zipfile.ZipFile(path) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
        if unpacked > MOST_BYTES:
            raise InputError(f"{path}: {unpacked / 1e9:.1f} GB unpacked, more than are read")
        with np.load(path, allow_pickle=False) as stored:
            found = {name: np.asarray(stored[name]) for name in wanted if name in stored}
    except InputError:
        raise
    except Exception as error:  # zipfile, zlib and NumPy raise a dozen unrelated types
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(f"{path}: is damaged ({reason}); {remedy}") from error
    for name, array in wanted.items():
        if name not in found:
            raise InputError(f"{path}: lacks the array '{name}'; {remedy}")
        if not array.fits(found[name]):
            sides = "x".join(str(side) for side in found[name].shape) or "single"
            raise InputError(
                f"{path}: the array '{name}' ({sides}, {found[name].dtype}) is not what it should "
                f"be, or holds NaN or infinity; {remedy}"
            )
    return found
