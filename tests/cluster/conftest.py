"""A real Slurm of two nodes, and the small workflow on it."""

import shutil
import tempfile
from pathlib import Path

import pytest
from cluster.slurm import Cluster, missing
from support.tiny_workflow import checkout


@pytest.fixture(scope="session")
def cluster():
    """The cluster, started."""
    if lacking := missing():
        pytest.fail(
            f"{', '.join(lacking)} not found: apt-get install slurmctld slurmd slurm-client munge"
        )
    # A short path: munge's socket must not have a long one.
    folder = Path(tempfile.mkdtemp(prefix="r3gw-slurm-"))
    found = Cluster(folder / "cluster")
    found.start()
    yield found
    found.stop()
    shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def checked_out(repository, tmp_path_factory) -> Path:
    """Copy of the workflow that all tests run in, one after the other."""
    return checkout(repository, tmp_path_factory.mktemp("slurm"))
