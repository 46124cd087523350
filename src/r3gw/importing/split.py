"""The split list of a scene: ``filename;split`` lines that say train or test for each photo."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from r3gw.files import InputError
from r3gw.importing.named_files import listed
from r3gw.scene.names import key_of, normalised

Split = Literal["train", "test"]
_COLUMNS = ("filename", "split")


@dataclass(frozen=True)
class SplitLine:
    """One line of a split list: the file name as written, and its split."""

    filename: str
    split: Split


def find_split_file(folder: Path) -> Path:
    """The one ``*_split.csv`` of a folder.

    Raises:
        InputError: If there is none, or several.
    """
    found = sorted(path for path in folder.glob("*") if path.name.lower().endswith("_split.csv"))
    if not found:
        raise InputError(
            f"{folder}: no *_split.csv here; write one with the header 'filename;split' and "
            "a line such as 'IMG_0001.jpg;train' per photo"
        )
    if len(found) > 1:
        names = listed(path.name for path in found)
        raise InputError(f"{folder}: {len(found)} split files ({names}); keep one")
    return found[0]


def read_split(path: Path) -> dict[str, SplitLine]:
    """The line of every photo, by its normalised name (r3gw.scene.names).

    Raises:
        InputError: If the separator, the header, a value or a duplicate name is wrong.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not text in UTF-8; save the split list as CSV") from None
    rows = [
        (number, [cell.strip() for cell in row])
        for number, row in enumerate(csv.reader(lines, delimiter=";"), start=1)
        if any(cell.strip() for cell in row)
    ]
    if not rows:
        raise InputError(f"{path}: is empty; it must name every photo and its split")
    name_column, split_column = _columns(path, rows[0][1])
    result: dict[str, SplitLine] = {}
    seen: set[str] = set()
    for number, row in rows[1:]:
        if len(row) <= max(name_column, split_column):
            raise InputError(f"{path}: line {number} has {len(row)} columns, expected 'file;split'")
        name, split = row[name_column], row[split_column].lower()
        if split not in ("train", "test"):
            raise InputError(
                f"{path}: line {number} puts {name} in the split '{row[split_column]}'; "
                "it must be train or test"
            )
        value: Split = "train" if split == "train" else "test"
        if key_of(name) in seen:
            raise InputError(f"{path}: line {number} names {name} a second time; keep one line")
        seen.add(key_of(name))
        result[normalised(name)] = SplitLine(name, value)
    return result


def _columns(path: Path, header: list[str]) -> tuple[int, int]:
    """Columns of the file name and the split."""
    names = [cell.lower() for cell in header]
    if all(column in names for column in _COLUMNS):
        return names.index("filename"), names.index("split")
    for separator, word in ((",", "a comma"), ("\t", "a tab"), ("|", "a bar")):
        if len(header) == 1 and separator in header[0]:
            raise InputError(
                f"{path}: columns are separated by {word}; separate them by a semicolon, "
                "as in 'filename;split'"
            )
    raise InputError(f"{path}: the first line is {';'.join(header)!r}; it must be 'filename;split'")
