"""Fixtures that every test may use."""

from pathlib import Path

import pytest
import torch

pytest_plugins = ["support.small_model", "support.tiny"]


@pytest.fixture(scope="session")
def repository() -> Path:
    """The repository's root folder."""
    return Path(__file__).parents[1]


@pytest.fixture(autouse=True, scope="session")
def one_thread() -> None:
    """Tests run single-threaded, so that results do not depend on the machine."""
    torch.set_num_threads(1)
