"""Copies of the workflow: one that has run, one in which nothing has."""

import shutil
from pathlib import Path

import pytest
from support.tiny_workflow import TWO, checkout, snakemake, started


@pytest.fixture(scope="session")
def pristine(repository, tmp_path_factory) -> Path:
    """Copy in which `all` has run and nothing since; not to be changed."""
    folder = checkout(repository, tmp_path_factory.mktemp("pristine"))
    done = snakemake(folder, "all")
    logs = "".join(path.read_text() for path in (folder / "logs").rglob("*.log"))
    assert done.returncode == 0, done.stderr + logs
    (folder / "all.log").write_text(done.stderr)
    return folder


@pytest.fixture(scope="session")
def finished(pristine, tmp_path_factory) -> Path:
    """The same, for tests that run more in it."""
    folder = tmp_path_factory.mktemp("finished") / "checkout"
    return Path(shutil.copytree(pristine, folder, symlinks=True))


@pytest.fixture(scope="session")
def with_twin(finished) -> Path:
    """The same copy, in which a second scene waits for its training."""
    done = snakemake(finished, "results/twin/checked.json", config=TWO)
    assert done.returncode == 0, done.stderr
    assert "tiny" not in {scene for _, scene in started(done.stderr)}
    return finished


@pytest.fixture
def untouched(repository, tmp_path) -> Path:
    """Copy in which nothing has run."""
    return checkout(repository, tmp_path)
