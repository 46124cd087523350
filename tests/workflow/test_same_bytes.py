"""A second run on the same machine gives the same bytes, but where something was measured."""

import re
import shutil
from pathlib import Path

import pytest
from support.tiny_workflow import snakemake

pytestmark = pytest.mark.slow

MEASURED = {"timing.json", "cost.json", "cost.csv"}


def test_a_second_run_gives_the_same_bytes(pristine, tmp_path):
    again = Path(shutil.copytree(pristine, tmp_path / "again", symlinks=True))
    shutil.rmtree(again / "results/tiny")
    done = snakemake(again, "all")
    assert done.returncode == 0, done.stderr
    first, second = (contents(folder / "results") for folder in (pristine, again))
    assert {Path(name).name for name in first} >= MEASURED | {
        "table1.csv",
        "images.csv",
        "runs.csv",
        "decomposition.csv",
        "metrics.json",
        "model.safetensors",
        "run.json",
        "history.csv",
        "report.html",
    }
    assert set(first) == set(second)
    assert [name for name in first if first[name] != second[name]] == []
    for name in ("tiny/full/seed0/timing.json", "cost.csv"):
        assert (pristine / "results" / name).read_bytes() != (again / "results" / name).read_bytes()


def contents(results: Path) -> dict[str, bytes]:
    """Every file of a run by name, measured ones empty, the report without its section on cost."""
    found = {}
    for path in sorted(results.rglob("*")):
        if path.is_file():
            content = b"" if path.name in MEASURED else path.read_bytes()
            if path.name == "report.html":
                content, sections = COST.subn(b"", content)
                assert sections == 1
            found[str(path.relative_to(results))] = content
    return found


COST = re.compile(rb"<h2[^>]*>Cost.*?(?=<h2)", re.DOTALL)
