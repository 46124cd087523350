"""What the compiled extensions were built from: the digest that their build writes into them.

`setup.py` runs this file before r3gw can be imported, so it needs the standard library alone.
"""

import hashlib
import mmap
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

_SUFFIXES = {".cpp", ".h"}
_MARK = re.compile(rb"r3gw built from ([0-9a-f]{16}) with ([0-9a-f]{16})\0")


@dataclass(frozen=True)
class BuiltFrom:
    """First 16 hexadecimal digits of the SHA-256 of the kernels' sources and of the flags."""

    sources: str
    flags: str


def kernel_sources(package: Path) -> list[Path]:
    """C++ files and headers of the kernels, sorted: those in the folders ``csrc`` of a package."""
    return sorted(path for path in package.rglob("csrc/*") if path.suffix in _SUFFIXES)


def sources_digest(package: Path) -> str:
    """Digest of names and contents of the kernels' sources."""
    digest = hashlib.sha256()
    for path in kernel_sources(package):
        digest.update(f"{path.relative_to(package).as_posix()}\n".encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]


def flags_digest(flags: Sequence[str]) -> str:
    """Digest of the compiler's and the linker's flags."""
    return hashlib.sha256("\n".join(flags).encode()).hexdigest()[:16]


def mark(built: BuiltFrom) -> str:
    """C++ source of the mark that `built_from` finds again in the compiled file."""
    text = f"r3gw built from {built.sources} with {built.flags}"
    return f'extern "C" __attribute__((used)) const char r3gw_built_from[] = "{text}";\n'


def built_from(extension: Path) -> BuiltFrom | None:
    """What a compiled extension was built from, without loading it; None if it does not say."""
    with (
        extension.open("rb") as file,
        mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content,
    ):
        found = _MARK.search(content)
        return None if found is None else BuiltFrom(found[1].decode(), found[2].decode())
