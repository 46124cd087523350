"""The import order in r3gw.layers holds: every import, and every C++ include, points downwards."""

import ast
import re
from pathlib import Path

import pytest

from r3gw.layers import LAYERS

SOURCE = Path(__file__).parents[1] / "src" / "r3gw"
LEVEL = {package: level for level, layer in enumerate(LAYERS) for package in layer}


def imported_packages(path: Path) -> set[str]:
    """Names of the r3gw packages that a module imports."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return {name.split(".")[1] for name in names if name.startswith("r3gw.")}


@pytest.mark.parametrize("package", LEVEL)
def test_package_imports_only_from_below(package):
    for path in (SOURCE / package).rglob("*.py"):
        for other in imported_packages(path) - {package}:
            assert LEVEL[other] < LEVEL[package], f"{path}: {package} must not import {other}"


def test_every_package_has_a_layer():
    assert {p.name for p in SOURCE.iterdir() if p.is_dir() and p.name != "__pycache__"} == set(
        LEVEL
    )


def sources_of(folder: Path) -> list[Path]:
    """The C++ files below a folder."""
    return [path for suffix in ("cpp", "h") for path in folder.rglob(f"*.{suffix}")]


def included_packages(path: Path) -> set[str]:
    """Names of the r3gw packages whose headers a C++ file includes."""
    return {name.split("/")[0] for name in re.findall(r'#include "([^"]+)"', path.read_text())}


@pytest.mark.parametrize("package", LEVEL)
def test_package_includes_only_headers_from_below(package):
    for path in sources_of(SOURCE / package):
        for other in included_packages(path) - {package}:
            assert LEVEL[other] < LEVEL[package], f"{path}: {package} must not include {other}"


def test_headers_are_named_by_their_whole_path():
    """From src/r3gw on, so that an include says which package it reaches into."""
    sources = sources_of(SOURCE)
    assert len(sources) > 30
    for path in sources:
        for name in re.findall(r'#include "([^"]+)"', path.read_text()):
            assert (SOURCE / name).is_file(), f"{path}: no header {name} below src/r3gw"
