"""Copies of the workflow: one in which `all` has run, shared, and fresh ones."""

from pathlib import Path

import pytest
from tiny_workflow import checkout, snakemake


@pytest.fixture(scope="session")
def finished(repository, tmp_path_factory) -> Path:
    """Copy in which `all` has run."""
    folder = checkout(repository, tmp_path_factory.mktemp("finished"))
    done = snakemake(folder, "all")
    logs = "".join(path.read_text() for path in (folder / "logs").rglob("*.log"))
    assert done.returncode == 0, done.stderr + logs
    return folder


@pytest.fixture
def untouched(repository, tmp_path) -> Path:
    """Copy in which nothing has run."""
    return checkout(repository, tmp_path)
