"""A scene before and after its import."""

import pytest
from support.configured_scene import ConfiguredScene


@pytest.fixture
def configured(tmp_path, repository):
    return ConfiguredScene(tmp_path, repository / "config")


@pytest.fixture
def made(configured):
    configured.make()
    return configured
