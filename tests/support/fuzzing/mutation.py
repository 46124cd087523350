"""Seeded mutations of a file's bytes: flips, cuts, copies, odd numbers, and valid containers."""

import io
import random
import re
import struct
import zipfile
import zlib

_NUMBERS = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_ODD_NUMBERS = (
    b"nan", b"inf", b"-inf", b"1e309", b"-1", b"0", b"1e-320", b"99999999999999999999",
    b"4294967296", b"-2147483649", b"0x10", b"1.5", b"", b"true", b"null", b"[]", b"{}",
)  # fmt: skip
_ODD_TEXT = (
    b"../../../etc/passwd", b"/etc/passwd", b"\xff\xfe", b"caf\xe9", b"\x00", b"\r\n",
    b"\xef\xbb\xbf", b"'", b'"', b"\\", b"{x}", b"$HOME", b"*&a", b"- - -", b"%s",
    b"[" * 300, b"9" * 400,
)  # fmt: skip
_PNG_MAGIC = b"\x89PNG\r\n\x1a\n"


def mutated(data: bytes, random_: random.Random) -> bytes:
    """``data`` with one to six mutations; the same state of ``random_`` gives the same bytes."""
    if data.startswith(b"PK\x03\x04") and random_.random() < 0.6:
        return _mutated_archive(data, random_)
    if data.startswith(_PNG_MAGIC) and random_.random() < 0.5:
        return _mutated_png(data, random_)
    for _ in range(random_.choice((1, 1, 1, 2, 3, 6))):
        data = random_.choice(_ways(data))(data, random_)
    return data


def _ways(data: bytes):
    ways = [_flip, _flip, _cut, _remove, _repeat, _insert, _integer, _integer, _text]
    if data[:200].isascii():
        ways += [_number, _number, _number, _line, _line]
    return ways


def _place(data: bytes, random_: random.Random) -> int:
    """Headers are where things are decided, so half of all places lie in the first 256 bytes."""
    end = min(len(data), 256) if random_.random() < 0.5 else len(data)
    return random_.randrange(end + 1)


def _flip(data: bytes, random_: random.Random) -> bytes:
    if not data:
        return data
    place = min(_place(data, random_), len(data) - 1)
    new = data[place] ^ (1 << random_.randrange(8)) if random_.random() < 0.5 else None
    return (
        data[:place] + bytes([random_.randrange(256) if new is None else new]) + data[place + 1 :]
    )


def _cut(data: bytes, random_: random.Random) -> bytes:
    return data[: _place(data, random_)]


def _remove(data: bytes, random_: random.Random) -> bytes:
    place = _place(data, random_)
    return data[:place] + data[place + random_.choice((1, 2, 4, 8, 64)) :]


def _repeat(data: bytes, random_: random.Random) -> bytes:
    place, length = _place(data, random_), random_.choice((1, 4, 16, 200))
    return data[:place] + data[place : place + length] * random_.choice((2, 3, 9)) + data[place:]


def _insert(data: bytes, random_: random.Random) -> bytes:
    place = _place(data, random_)
    return data[:place] + random_.randbytes(random_.choice((1, 2, 4, 8, 40))) + data[place:]


def _integer(data: bytes, random_: random.Random) -> bytes:
    size = random_.choice((1, 2, 4, 8))
    top = 1 << (8 * size)
    value = random_.choice((0, 1, top - 1, top // 2, top // 2 - 1, top // 4, 255, 65536)) % top
    place = _place(data, random_)
    order = random_.choice(("little", "big"))
    return data[:place] + value.to_bytes(size, order) + data[place + size :]


def _text(data: bytes, random_: random.Random) -> bytes:
    place = _place(data, random_)
    end = place + random_.choice((0, 0, 3, 10))
    return data[:place] + random_.choice(_ODD_TEXT) + data[end:]


def _number(data: bytes, random_: random.Random) -> bytes:
    found = list(_NUMBERS.finditer(data))
    if not found:
        return data
    match = random_.choice(found)
    return data[: match.start()] + random_.choice(_ODD_NUMBERS) + data[match.end() :]


def _line(data: bytes, random_: random.Random) -> bytes:
    lines = data.split(b"\n")
    place = random_.randrange(len(lines))
    other = lines[random_.randrange(len(lines))]
    lines[place : place + 1] = random_.choice(([], [other], [lines[place], other], [b""]))
    return b"\n".join(lines)


def _mutated_archive(data: bytes, random_: random.Random) -> bytes:
    """A valid ZIP of which one member is mutated, left out or doubled."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = [(name, archive.read(name)) for name in archive.namelist()]
    place = random_.randrange(len(members))
    name, content = members[place]
    kind = random_.random()
    if kind < 0.1:
        members.pop(place)
    elif kind < 0.15:
        members[place] = name + "x", content
    else:
        members[place] = name, mutated(content, random_)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for each in members:
            archive.writestr(*each)
    return stream.getvalue()


def _mutated_png(data: bytes, random_: random.Random) -> bytes:
    """A PNG of which one chunk is mutated, with a right checksum."""
    chunks, position = [], len(_PNG_MAGIC)
    while position + 12 <= len(data):
        (length,) = struct.unpack(">I", data[position : position + 4])
        body = data[position + 4 : position + 8 + length]
        chunks.append(body)
        position += 12 + length
    place = random_.randrange(len(chunks))
    kind, body = chunks[place][:4], chunks[place][4:]
    if kind == b"IDAT" and random_.random() < 0.7:
        body = zlib.compress(mutated(zlib.decompress(body), random_))
    else:
        body = mutated(body, random_)
    chunks[place] = kind + body
    parts = (struct.pack(">I", len(c) - 4) + c + struct.pack(">I", zlib.crc32(c)) for c in chunks)
    return _PNG_MAGIC + b"".join(parts)
