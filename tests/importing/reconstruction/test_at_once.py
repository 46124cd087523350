"""Collections that incremental mapping gives up on: all photos are placed at once."""

import os
import shutil
from pathlib import Path

import cv2
import numpy as np
import pycolmap
import pytest
from scipy.spatial.transform import Rotation
from support.made_up_place import place_photo

from r3gw.importing.reconstruction import incremental
from r3gw.importing.settings import PhotosScene
from r3gw.importing.stage import import_scene

pytestmark = pytest.mark.slow

LUND = Path(os.environ.get("R3GW_LUND", Path(__file__).parents[4] / "shared" / "data" / "lund"))
SETTINGS = PhotosScene(format="photos", path=".", hold_out=None)


@pytest.fixture(scope="module")
def photos(tmp_path_factory):
    """Seven photos around the place, and where each was taken."""
    folder = tmp_path_factory.mktemp("made")
    centres = {}
    for number, azimuth in enumerate(np.linspace(-40, 40, 7)):
        angle = np.radians(azimuth)
        centre = np.array([4 * np.sin(angle), -0.2 * (number % 3), 5 - 5 * np.cos(angle)])
        turn = Rotation.from_euler("YX", [-azimuth, 3], degrees=True)
        cv2.imwrite(str(folder / f"{number}.png"), place_photo(turn.as_matrix().T, centre))
        centres[f"{number}"] = centre
    return folder, centres


@pytest.fixture
def gives_up(monkeypatch):
    """Incremental mapping that finds no model."""
    monkeypatch.setattr(pycolmap, "incremental_mapping", lambda *_: {})


@pytest.mark.usefixtures("gives_up")
def test_cameras_stand_where_they_stood(photos, tmp_path):
    folder, centres = photos
    scene = import_scene("at_once", SETTINGS, folder, tmp_path / "scene", num_threads=1)
    assert len(scene.views) == 7
    ours = np.stack([view.camera.centre.numpy() for view in scene.views])
    true = np.stack([centres[view.name] for view in scene.views])
    ours, true = ours - ours.mean(axis=0), true - true.mean(axis=0)
    turn, _ = Rotation.align_vectors(true, ours * np.linalg.norm(true) / np.linalg.norm(ours))
    aligned = turn.apply(ours) * np.linalg.norm(true) / np.linalg.norm(ours)
    assert np.abs(aligned - true).max() < 0.1  # of 5.1 from the first to the last
    report = (tmp_path / "scene" / "sfm_report.json").read_text()
    assert "placed at once" in report


@pytest.mark.usefixtures("gives_up")
def test_same_seed_gives_the_same_bytes(photos, tmp_path):
    for name in ("first", "second"):
        import_scene("same", SETTINGS, photos[0], tmp_path / name, num_threads=1)
    for name in ("scene.json", "points.npz"):
        assert (tmp_path / "first" / name).read_bytes() == (tmp_path / "second" / name).read_bytes()


def test_nothing_is_placed_at_once_where_photos_follow_each_other(photos, tmp_path, monkeypatch):
    monkeypatch.setattr(incremental, "mapped_at_once", None)
    scene = import_scene("usual", SETTINGS, photos[0], tmp_path / "scene", num_threads=1)
    assert len(scene.views) == 7


@pytest.mark.skipif(not LUND.is_dir(), reason=f"no photos of a street in Lund in {LUND}")
def test_photos_straight_along_a_street_register(tmp_path):
    folder = tmp_path / "photos"
    folder.mkdir()
    for number in range(1, 11):
        shutil.copy(LUND / f"{number:02d}.jpg", folder)
    scene = import_scene("street", SETTINGS, folder, tmp_path / "scene", num_threads=2)
    assert len(scene.views) == 10
    centres = np.stack([view.camera.centre.numpy() for view in scene.views])
    steps = np.diff(centres, axis=0)
    forward = np.stack([np.array(view.cam_from_world)[2, :3] for view in scene.views])[:-1]
    cosine = (steps * forward).sum(-1) / np.linalg.norm(steps, axis=-1)
    assert (cosine > 0.9).all()  # every step leads on along the street
