"""The import order in r3gw.layers holds: every import points to a lower layer."""

import ast
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
    packages = {name.split(".")[1] for name in names if name.startswith("r3gw.")}
    return packages - {"_C"}  # the compiled extension: every package holds its own kernels


@pytest.mark.parametrize("package", LEVEL)
def test_package_imports_only_from_below(package):
    for path in (SOURCE / package).rglob("*.py"):
        for other in imported_packages(path) - {package}:
            assert LEVEL[other] < LEVEL[package], f"{path}: {package} must not import {other}"


def test_every_package_has_a_layer():
    assert {p.name for p in SOURCE.iterdir() if p.is_dir() and p.name != "__pycache__"} == set(
        LEVEL
    )
