"""A copy of the package that tests may edit, with a stand-in for its compiled extension."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import r3gw
from r3gw.native.build import BuiltFrom, mark, sources_digest

PACKAGE = Path(r3gw.__file__).parent


def copy_package(folder: Path) -> Path:
    """Copy the package's sources into ``folder`` and pretend to build them; returns the copy."""
    without = shutil.ignore_patterns("*.so", "__pycache__")
    package = Path(shutil.copytree(PACKAGE, folder / "r3gw", ignore=without))
    pretend_build(package)
    return package


def pretend_build(package: Path) -> None:
    """Write a file where the extension would be, with the mark that a build of today would have."""
    text = mark(BuiltFrom(sources_digest(package), "0123456789abcdef")).split('"')[-2]
    extension = package / f"_C{EXTENSION_SUFFIXES[0]}"
    extension.write_bytes(b"\x7fELF" + text.encode() + b"\0rest")


@contextmanager
def edited(path: Path) -> Iterator[None]:
    """Append a comment to a source file for a while."""
    before = path.read_bytes()
    comment = (
        b"\n/* edited */\n" if path.suffix in {".cpp", ".h", ".css", ".js"} else b"\n# edited\n"
    )
    path.write_bytes(before + comment)
    try:
        yield
    finally:
        path.write_bytes(before)
