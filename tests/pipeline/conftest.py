"""The files that a run's settings are resolved from."""

import pytest


@pytest.fixture
def files(repository):
    return {
        "train_file": repository / "config/train.yaml",
        "variants_file": repository / "config/variants.yaml",
    }
