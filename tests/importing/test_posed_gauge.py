"""Scenes whose world is tilted and of any scale: levelled, and back again for exports."""

import numpy as np
import pycolmap
import pytest
import torch
from support import nerf_osr_layout

from r3gw.importing.settings import ColmapScene
from r3gw.importing.stage import import_scene
from r3gw.scene import load_points


@pytest.fixture
def folder(tmp_path):
    """A tiny COLMAP folder; photos of any suffix."""
    place = nerf_osr_layout.build(tmp_path / "place")
    (tmp_path / "colmap").mkdir()
    (place.undistorted / "images").rename(tmp_path / "colmap" / "images")
    (place.undistorted / "sparse" / "0").rename(tmp_path / "colmap" / "sparse")
    return tmp_path / "colmap"


def imported(folder, target, **changes):
    settings = ColmapScene(format="colmap", path=".", **changes)
    return import_scene("place", settings, folder, target, num_threads=1)


def test_scene_does_not_depend_on_the_frame_of_the_model(folder, tmp_path):
    first = imported(folder, tmp_path / "first")
    model = pycolmap.Reconstruction(str(folder / "sparse"))
    turn = pycolmap.Rotation3d(np.array([0.9, -0.4, 0.3]))
    model.transform(pycolmap.Sim3d(7.0, turn, np.array([10.0, -20.0, 5.0])))
    model.write(str(folder / "sparse"))
    second = imported(folder, tmp_path / "second")
    for view, other in zip(first.views, second.views, strict=True):
        np.testing.assert_allclose(
            np.array(view.cam_from_world), np.array(other.cam_from_world), rtol=0, atol=1e-4
        )
    xyz = [load_points(tmp_path / name).xyz for name in ("first", "second")]
    np.testing.assert_allclose(*xyz, rtol=0, atol=1e-4)
    # Without it, the model's frame stays.
    given = imported(folder, tmp_path / "given", up="given", extent=None)
    source = {image.name.split(".")[0]: image for image in model.images.values()}
    for view in given.views:
        expected = source[view.name].cam_from_world().matrix()
        np.testing.assert_allclose(view.cam_from_world[:3], expected, rtol=0, atol=1e-12)


def test_source_from_scene_gives_back_what_the_model_held(folder, tmp_path):
    scene = imported(folder, tmp_path / "scene")
    back = scene.source_from_scene
    model = pycolmap.Reconstruction(str(folder / "sparse"))
    assert abs(back.scale - 1) > 0.1
    images = {image.name.split(".")[0]: image for image in model.images.values()}
    for view in scene.views:
        expected = images[view.name].cam_from_world().matrix()
        found = back.camera(view.camera.cam_from_world)[:3].numpy()
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
    points = back.points(torch.from_numpy(load_points(tmp_path / "scene").xyz).double())
    source = [model.points3D[identifier].xyz for identifier in sorted(model.points3D)]
    np.testing.assert_allclose(points.numpy(), np.array(source), rtol=0, atol=1e-5)
