"""Fixtures of the page's tests: a scene that is hard to draw, and its page."""

from pathlib import Path

import pytest
from support.blob import blob_gaussians, write_blob_scene
from support.chromium import find_browser

from r3gw.relight.gaussians import Relightable
from r3gw.scene import load_scene
from r3gw.view.page import page_html
from r3gw.view.payload import PageOptions, Payload, payload_of


@pytest.fixture(scope="session")
def gaussians() -> Relightable:
    """Random thin Gaussians with shadows before a half-dome of sky."""
    return blob_gaussians()


@pytest.fixture(scope="session")
def scene_folder(tmp_path_factory) -> Path:
    """Folder of the blob's five cameras."""
    folder = tmp_path_factory.mktemp("scene")
    write_blob_scene(folder)
    return folder


@pytest.fixture(scope="session")
def payload(gaussians, scene_folder) -> Payload:
    """Content of the blob's page."""
    options = PageOptions(title="A <blob> & co")
    return payload_of(gaussians, load_scene(scene_folder), scene_folder, options)


@pytest.fixture(scope="session")
def html(payload) -> str:
    """The blob's page."""
    return page_html(payload)


@pytest.fixture
def browser() -> str:
    """Path of Chromium; the test is skipped without one."""
    found = find_browser()
    if found is None:
        pytest.skip("no Chromium is installed (apt-get install chromium)")
    return found
