"""One table of vertices as a binary PLY file: the little of the format that Gaussians need.

Our own because the one library that keeps arbitrary properties is under the GPL; the tests read our
files with it.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from r3gw.files import atomic_path

DTYPES = {"float": "<f4", "uchar": "u1"}
NAMES = {"f4": "float", "u1": "uchar"}
FIRST_LINES = ["ply", "format binary_little_endian 1.0"]
LAST_LINE = "end_header"
LONGEST_HEADER = 65536


def write_rows(path: Path, rows: NDArray[Any], comments: Sequence[str]) -> None:
    """Write a structured array of float32 and uint8 fields as the element ``vertex``."""
    properties = [
        f"property {NAMES[field.str[1:]]} {name}"
        for name, (field, *_) in (rows.dtype.fields or {}).items()
    ]
    lines = [
        *FIRST_LINES,
        *(f"comment {comment}" for comment in comments),
        f"element vertex {len(rows)}",
        *properties,
        LAST_LINE,
    ]
    with atomic_path(path) as temporary:
        temporary.write_bytes("\n".join(lines).encode() + b"\n" + rows.tobytes())


def read_rows(path: Path) -> tuple[NDArray[Any], list[str]]:
    """Return the rows and the comments of a file of the form that `write_rows` writes.

    Raises:
        ValueError: If the file is of another form; the message says in what.
    """
    content = path.read_bytes()
    end = content.find(f"\n{LAST_LINE}\n".encode(), 0, LONGEST_HEADER)
    lines = content[: max(end, 0)].decode(errors="replace").split("\n")
    if lines[:2] != FIRST_LINES:
        raise ValueError("no binary little-endian PLY header")
    comments, fields, count = [], [], None
    for line in lines[2:]:
        match line.split(" ", 2):
            case ["comment", *_]:
                comments.append(line.removeprefix("comment "))
            case ["element", "vertex", number] if count is None and number.isdecimal():
                count = int(number)
            case ["property", kind, name] if count is not None and kind in DTYPES:
                fields.append((name, DTYPES[kind]))
            case _:
                raise ValueError(f"unexpected line '{line[:60]}' in the header")
    dtype, data = np.dtype(fields), content[end + len(LAST_LINE) + 2 :]
    if count is None or len(data) != count * dtype.itemsize:
        raise ValueError(f"{len(data)} bytes of rows, {(count or 0) * dtype.itemsize} expected")
    return np.frombuffer(data, dtype), comments
