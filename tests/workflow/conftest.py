"""Copies of the workflow: one that has run, one in which nothing has."""

import shutil
from pathlib import Path

import pytest
from support.tiny_workflow import TWO, checkout, snakemake, started

PRISTINE = "finished_pristine"


@pytest.fixture(scope="session")
def finished(repository, tmp_path_factory) -> Path:
    """Copy in which `all` has run; tests may run more in it."""
    folder = checkout(repository, tmp_path_factory.mktemp("finished"))
    done = snakemake(folder, "all")
    logs = "".join(path.read_text() for path in (folder / "logs").rglob("*.log"))
    assert done.returncode == 0, done.stderr + logs
    (folder / "all.log").write_text(done.stderr)
    shutil.copytree(folder, folder.with_name(PRISTINE), symlinks=True)
    return folder


@pytest.fixture(scope="session")
def pristine(finished) -> Path:
    """What `finished` held when `all` had just run there; to be read and copied alone."""
    return finished.with_name(PRISTINE)


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
