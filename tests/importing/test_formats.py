"""One embedded scene written in every format gives the same scene."""

import numpy as np
import pytest
from support import formats

from r3gw.benchmark.generate import generate
from r3gw.imaging.files import read_labels
from r3gw.importing.readers import nerf_osr_original
from r3gw.importing.readers.colmap_model import read_model
from r3gw.importing.settings import ColmapScene, NerfOsrOriginalScene, NerfOsrScene, NerfstudioScene
from r3gw.importing.stage import import_scene
from r3gw.scene import load_points

GIVEN = {"path": ".", "extent": None, "up": "given"}


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A small scene of the embedded benchmark."""
    folder = tmp_path_factory.mktemp("formats") / "chapel"
    generate(
        "chapel", 5, folder, size_px=(64, 48), train_views=4, test_views=2, samples=1,
        show_progress=False,
    )  # fmt: skip
    return folder


def imported(settings, source, target):
    return import_scene("chapel", settings, source, target, num_threads=1), target


@pytest.fixture(scope="module")
def expected(source):
    """The scene as the NeRF-OSR layout gives it."""
    settings = NerfOsrScene(format="nerf-osr", path=".")
    return imported(settings, source, source.parent / "expected")


def assert_same(found, expected, *, pose_atol, masks=("is_valid", "is_sky")):
    (scene, folder), (reference, reference_folder) = found, expected
    assert [view.name for view in scene.views] == [view.name for view in reference.views]
    for view, other in zip(scene.views, reference.views, strict=True):
        assert (view.split, view.session) == (other.split, other.session)
        assert (view.width, view.height) == (other.width, other.height)
        np.testing.assert_allclose(view.intrinsics, other.intrinsics, rtol=1e-12, atol=1e-9)
        np.testing.assert_allclose(
            np.array(view.cam_from_world), np.array(other.cam_from_world), rtol=0, atol=pose_atol
        )
        for path in (view.image, *(f"given/{kind}/{view.name}.png" for kind in masks)):
            assert (folder / path).read_bytes() == (reference_folder / path).read_bytes(), path
        assert view.evaluation == other.evaluation
        if view.evaluation is not None:
            for path in (view.evaluation.mask, view.evaluation.env_map):
                assert (folder / path).read_bytes() == (reference_folder / path).read_bytes()
    assert any(view.evaluation for view in scene.views)


def assert_same_points(found, expected, atol):
    points, reference = load_points(found[1]), load_points(expected[1])
    np.testing.assert_allclose(points.xyz, reference.xyz, rtol=0, atol=atol)
    assert np.array_equal(points.rgb, reference.rgb)


@pytest.mark.slow
def test_nerf_osr_with_its_quirks(source, expected, tmp_path):
    dropped = formats.as_published(source, tmp_path / "published")
    settings = NerfOsrScene(format="nerf-osr", path=".")
    found = imported(settings, tmp_path / "published", tmp_path / "scene")
    assert_same(found, expected, pose_atol=1e-12, masks=("is_valid",))
    assert_same_points(found, expected, atol=1e-6)
    given = {path.stem for path in (tmp_path / "scene" / "given" / "is_sky").iterdir()}
    assert given == {view.name for view in expected[0].views} - set(dropped)


def test_colmap_folder(source, expected, tmp_path):
    formats.colmap_folder(source, tmp_path / "colmap")
    found = imported(ColmapScene(format="colmap", **GIVEN), tmp_path / "colmap", tmp_path / "scene")
    assert_same(found, expected, pose_atol=0)
    assert_same_points(found, expected, atol=0)


def test_nerfstudio(source, expected, tmp_path):
    formats.nerfstudio(source, tmp_path / "nerfstudio")
    settings = NerfstudioScene(format="nerfstudio", **GIVEN)
    found = imported(settings, tmp_path / "nerfstudio", tmp_path / "scene")
    assert_same(found, expected, pose_atol=1e-9)
    assert_same_points(found, expected, atol=1e-5)


def test_original_nerf_osr(source, expected, tmp_path, monkeypatch):
    """Its points are triangulated, which needs larger photos: see test_triangulate."""
    formats.nerf_osr_original(source, tmp_path / "osr")
    points = read_model(source / "undistorted" / "sparse" / "0").points
    monkeypatch.setattr(nerf_osr_original, "triangulated_points", lambda *_args, **_keys: points)
    settings = NerfOsrOriginalScene(format="nerf-osr-original", **GIVEN)
    found = imported(settings, tmp_path / "osr", tmp_path / "scene")
    assert_same(found, expected, pose_atol=1e-9, masks=("is_valid",))
    for view in found[0].views:
        labels = read_labels(tmp_path / "scene" / "given" / "labels" / f"{view.name}.png")
        assert np.array_equal(labels, formats.labels_of(source, view.name))


def test_labels_are_scaled_without_new_colours(source, tmp_path, monkeypatch):
    formats.nerf_osr_original(source, tmp_path / "osr")
    points = read_model(source / "undistorted" / "sparse" / "0").points
    monkeypatch.setattr(nerf_osr_original, "triangulated_points", lambda *_args, **_keys: points)
    settings = NerfOsrOriginalScene(format="nerf-osr-original", max_image_px=40, **GIVEN)
    scene, folder = imported(settings, tmp_path / "osr", tmp_path / "scene")
    colours = {formats.SKY, formats.PERSON, formats.BUILDING}
    for view in scene.views:
        labels = read_labels(folder / "given" / "labels" / f"{view.name}.png")
        assert labels.shape == (30, 40, 3)
        assert {tuple(colour) for colour in labels.reshape(-1, 3).tolist()} <= colours
