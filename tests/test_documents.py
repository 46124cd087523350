"""What documents and docstrings name is there: modules, functions, files, headings."""

import importlib
import re
from pathlib import Path

import pytest

from r3gw.layers import LAYERS

ROOT = Path(__file__).parents[1]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("config/*.md")])
SOURCES = sorted(
    path
    for folder in ("src", "tests", "benchmarks", "workflow")
    for path in (ROOT / folder).rglob("*")
    if path.suffix in {".py", ".smk", ".h", ".cpp"}
)
NAME = re.compile(r"(?<!ops\.)\br3gw(?:\.[A-Za-z_]\w*)+(?!\w*: )")
# A file of the repository by its path; commands name files of results and of users too.
FILE = re.compile(r"(?<![\w/.-])(?:docs|tests|benchmarks|config|workflow|src)/[\w/.-]*\w\.\w+")
LINK = re.compile(r"\]\(([^)\s]+)\)")
# It tells what was, by the names of its time.
HISTORY = ROOT / "CHANGELOG.md"
CHECKED = [path for path in (*DOCUMENTS, *SOURCES) if path != HISTORY]


def shown(path: Path) -> str:
    return str(path.relative_to(ROOT))


def resolves(name: str) -> bool:
    """Whether a dotted name is a module, or something in one."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for attribute in parts[count:]:
            annotated = getattr(found, "__annotations__", {})
            fields = getattr(found, "model_fields", {})
            if not hasattr(found, attribute) and attribute not in {**annotated, **fields}:
                return False
            found = getattr(found, attribute, object())
        return True
    return False


@pytest.mark.parametrize("path", [p for p in CHECKED if p.suffix not in {".h", ".cpp"}], ids=shown)
def test_names_of_the_package_are_there(path):
    names = set(NAME.findall(path.read_text()))
    names -= {name for name in names if name.endswith(("._C", ".yaml", ".json", ".sif"))}
    names -= {"r3gw.maps", "r3gw.mapsRead", "r3gw.probe"}  # JavaScript's, in the viewer's page
    assert [name for name in sorted(names) if not resolves(name)] == []


@pytest.mark.parametrize("path", CHECKED, ids=shown)
def test_files_of_the_repository_are_there(path):
    text = path.read_text()
    assert [name for name in sorted(set(FILE.findall(text))) if not (ROOT / name).exists()] == []


@pytest.mark.parametrize("path", DOCUMENTS, ids=shown)
def test_links_lead_somewhere(path):
    for link in LINK.findall(path.read_text()):
        if link.startswith(("http://", "https://", "mailto:")):
            continue
        name, _, anchor = link.partition("#")
        target = path if not name else path.parent / name
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target), link


def test_the_map_of_contributing_is_the_order_of_layers():
    text = (ROOT / "CONTRIBUTING.md").read_text()
    table = text.split("| Package (bottom to top) | Owns |")[1].split("\n\n")[0]
    packages = re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)
    assert packages == [name for layer in LAYERS for name in layer]


def anchors(document: Path) -> set[str]:
    """Anchors of a document's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.+)$", document.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
