"""The vertices of PLY files, in every dialect that scanners, viewers and trainers write.

G. Turk, "The PLY Polygon File Format", 1994: a text header that lists elements with their
properties, then rows as text or in either byte order. Read are both families of type names,
comments and obj_info by anybody, line ends of every system, and elements with lists before and
after the vertices. Our own because the one library that keeps arbitrary properties is under the
GPL; the tests hold it against that library.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from r3gw.files.atomic import write_bytes

_KINDS = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_WRITTEN = {"f4": "float", "u1": "uchar"}
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": "="}
# Editors put a byte order mark in front, and some writers blanks behind these two lines.
_FIRST_LINE = re.compile(rb"(?:\xef\xbb\xbf)?ply[ \t]*(\r\n|\n|\r)", re.IGNORECASE)
_LAST_LINE = rb"end_header[ \t]*"
_LONGEST_HEADER = 1 << 20
_MOST_PROPERTIES = 4096


@dataclass(frozen=True)
class _Property:
    """A value of a row; ``counted_by`` is the type of a list's length, None for a single value."""

    name: str
    kind: str
    counted_by: str | None = None


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: list[_Property]

    @property
    def has_lists(self) -> bool:
        return any(prop.counted_by is not None for prop in self.properties)

    def row(self, order: str) -> np.dtype[Any]:
        """Single values only."""
        single = [prop for prop in self.properties if prop.counted_by is None]
        return np.dtype([(prop.name, order + prop.kind) for prop in single])


@dataclass(frozen=True)
class _Header:
    order: str
    is_text: bool
    comments: list[str]
    elements: list[_Element]
    end: int


def write_vertices(path: Path, rows: NDArray[Any], comments: Sequence[str]) -> None:
    """Write a structured array of float32 and uint8 fields, little-endian, atomically."""
    properties = [
        f"property {_WRITTEN[field.str[1:]]} {name}"
        for name, (field, *_) in (rows.dtype.fields or {}).items()
    ]
    lines = [
        "ply",
        "format binary_little_endian 1.0",
        *(f"comment {comment}" for comment in comments),
        f"element vertex {len(rows)}",
        *properties,
        "end_header",
    ]
    write_bytes(path, "\n".join(lines).encode() + b"\n" + rows.tobytes())


def read_vertices(path: Path) -> tuple[NDArray[Any], list[str]]:
    """Return the vertices as a structured array, and the comments; lists are passed over.

    Raises:
        ValueError: If the file is no PLY file with vertices, or is cut off; the message says why.
    """
    data = path.read_bytes()
    header = _header(data)
    names = [element.name for element in header.elements]
    if "vertex" not in names:
        raise ValueError("it has no element 'vertex'")
    number = names.index("vertex")
    vertex, before = header.elements[number], header.elements[:number]
    is_last = number == len(names) - 1
    if header.is_text:
        return _text_rows(data[header.end :], before, vertex, is_last), header.comments
    position = header.end
    for element in before:
        position = _behind(data, position, element, header.order)
    if vertex.has_lists:
        return _rows_with_lists(data, position, vertex, header.order), header.comments
    row = vertex.row(header.order)
    needed, there = vertex.count * row.itemsize, len(data) - position
    if there < needed or (is_last and data[position + needed :].strip()):
        raise ValueError(f"{there} bytes of rows, {needed} expected")
    return np.frombuffer(data, row, vertex.count, position), header.comments


def _header(data: bytes) -> _Header:
    first = _FIRST_LINE.match(data)
    if first is None:
        raise ValueError("no PLY header")
    line_end = first.group(1)
    ending = re.compile(line_end + _LAST_LINE + b"(?:" + line_end + rb"|\Z)")
    last = ending.search(data, first.end() - len(line_end), _LONGEST_HEADER)
    if last is None:
        raise ValueError("no PLY header")
    lines = data[: last.start()].decode(errors="replace").split(line_end.decode())
    order, comments, elements = None, [], []
    for line in lines[1:]:
        match line.split():
            case ["comment", *_]:
                comments.append(line.partition(" ")[2])
            case ["obj_info", *_] | []:
                pass
            case ["format", word, "1.0"] if word in _ORDERS and order is None:
                order = word
            case ["element", name, count] if count.isascii() and count.isdecimal():
                elements.append(_Element(name, int(count), []))
            case ["property", *words] if elements:
                elements[-1].properties.append(_property(words, line))
            case _:
                raise ValueError(f"unexpected line '{line[:60]}' in the header")
    if order is None or any(not element.properties for element in elements):
        raise ValueError("its header lacks the format or an element's properties")
    if sum(len(element.properties) for element in elements) > _MOST_PROPERTIES:
        raise ValueError(f"it has more than {_MOST_PROPERTIES} properties")
    return _Header(_ORDERS[order], order == "ascii", comments, elements, last.end())


def _property(words: list[str], line: str) -> _Property:
    match words:
        case [kind, name, *more] if kind in _KINDS:  # CloudCompare's names may hold blanks
            return _Property(" ".join((name, *more)), _KINDS[kind])
        case ["list", count, kind, name] if kind in _KINDS and _KINDS.get(count, "f")[0] in "iu":
            return _Property(name, _KINDS[kind], _KINDS[count])
    raise ValueError(f"unexpected line '{line[:60]}' in the header")


def _behind(data: bytes, position: int, element: _Element, order: str) -> int:
    """Where an element that nobody asked for ends."""
    if not element.has_lists:
        position += element.count * element.row(order).itemsize
    else:
        for _ in range(element.count):
            position = _behind_row(data, position, element, order, {})
    if position > len(data):
        raise ValueError(f"it ends inside the element '{element.name}'")
    return position


def _behind_row(
    data: bytes, position: int, element: _Element, order: str, values: dict[str, Any]
) -> int:
    """Where a row with lists ends; its single values are added to ``values``."""
    for prop in element.properties:
        kind = np.dtype(order + (prop.counted_by or prop.kind))
        if position + kind.itemsize > len(data):
            raise ValueError(f"it ends inside the element '{element.name}'")
        value = np.frombuffer(data, kind, 1, position)[0]
        position += kind.itemsize
        if prop.counted_by is None:
            values[prop.name] = value
        elif value < 0:
            raise ValueError(f"a list in '{element.name}' has a negative length")
        else:
            position += int(value) * np.dtype(prop.kind).itemsize
    return position


def _rows_with_lists(data: bytes, position: int, vertex: _Element, order: str) -> NDArray[Any]:
    row = vertex.row(order)
    if vertex.count * row.itemsize > len(data):
        raise ValueError(f"{len(data)} bytes cannot hold {vertex.count} rows")
    result = np.empty(vertex.count, row)
    for number in range(vertex.count):
        values: dict[str, Any] = {}
        position = _behind_row(data, position, vertex, order, values)
        result[number] = tuple(values[name] for name in row.names or ())
    if position > len(data):
        raise ValueError("it ends inside the element 'vertex'")
    return result


def _text_rows(
    body: bytes, before: Sequence[_Element], vertex: _Element, is_last: bool
) -> NDArray[Any]:
    """One row is one line, as in every file that is written by a program."""
    lines = [line for line in body.splitlines() if line.strip()]
    first = sum(element.count for element in before)
    wanted = lines[first : first + vertex.count]
    if len(wanted) < vertex.count or (is_last and len(lines) > first + vertex.count):
        raise ValueError(f"{max(0, len(lines) - first)} rows, {vertex.count} expected")
    words = [_single_words(line.split(), vertex) for line in wanted]
    row = vertex.row("=")
    table = np.array(words, dtype=np.float64).reshape(vertex.count, len(row.names or ()))
    result = np.empty(vertex.count, row)
    for name, column in zip(row.names or (), table.T, strict=True):
        kind = row[name]
        if kind.kind in "iu" and column.size:
            limits = np.iinfo(kind)
            if not ((column >= limits.min) & (column <= limits.max)).all():
                raise ValueError(f"the property '{name}' holds values that its type cannot")
        result[name] = column
    return result


def _single_words(words: list[bytes], vertex: _Element) -> list[bytes]:
    """The words of a row that belong to single values."""
    if not vertex.has_lists:
        if len(words) != len(vertex.properties):
            raise ValueError(f"a row has {len(words)} values, {len(vertex.properties)} expected")
        return words
    kept, position = [], 0
    for prop in vertex.properties:
        if position >= len(words):
            raise ValueError("a row is too short")
        if prop.counted_by is None:
            kept.append(words[position])
            position += 1
        else:
            length = int(words[position])
            if length < 0:
                raise ValueError("a list has a negative length")
            position += 1 + length
    if position != len(words):
        raise ValueError(f"a row has {len(words)} values, {position} expected")
    return kept
