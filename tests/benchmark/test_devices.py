"""r3gw.benchmark.devices, visits: lenses against pycolmap, originals against their photos."""

import cv2
import numpy as np
import pycolmap
import pytest
import torch

from r3gw.benchmark.devices import DEVICES
from r3gw.benchmark.generate import generate
from r3gw.benchmark.lights import Session
from r3gw.benchmark.visits import with_visits
from r3gw.geometry.cameras import Camera

SIZE = (320, 212)
POSED = Camera(torch.eye(4, dtype=torch.float64), (1.0, 1.0, 0.0, 0.0), *SIZE)


@pytest.mark.parametrize("device", DEVICES)
def test_lens_is_colmaps(device):
    camera = device.camera(POSED, SIZE)
    focal_px, _, cx, cy = camera.intrinsics
    width, height = device.original_size(camera)
    lens = pycolmap.Camera(
        model="SIMPLE_RADIAL",
        width=width,
        height=height,
        params=[focal_px, width / 2, height / 2, device.distortion],
    )
    pixels = np.random.default_rng(0).uniform((0, 0), (camera.width, camera.height), (50, 2))
    rays = np.column_stack([(pixels - (cx, cy)) / focal_px, np.ones(50)])
    expected = np.array([lens.img_from_cam(ray) for ray in rays]).reshape(50, 2)
    np.testing.assert_allclose(device.distorted(pixels, camera), expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("device", DEVICES)
def test_dots_lie_where_the_lens_puts_them(device):
    camera = device.camera(POSED, SIZE)
    dots = np.stack(np.meshgrid([60.0, 110.0, 150.0], [40.0, 100.0, 150.0]), -1).reshape(-1, 2)
    dots = dots[(dots < (camera.width - 20, camera.height - 20)).all(axis=1)]
    photo = np.zeros((camera.height, camera.width, 3), np.uint8)
    for x, y in dots:  # pixel centres lie at +0.5
        photo[int(y) - 2 : int(y) + 3, int(x) - 2 : int(x) + 3] = 255
    original = device.original(photo, camera)
    for x, y in device.distorted(dots + 0.5, camera):
        window = original[int(y) - 6 : int(y) + 7, int(x) - 6 : int(x) + 7, 0].astype(float)
        moments = cv2.moments(window)
        seen = (moments["m10"] / moments["m00"], moments["m01"] / moments["m00"])
        found = np.add(seen, (int(x) - 6 + 0.5, int(y) - 6 + 0.5))
        np.testing.assert_allclose(found, (x, y), rtol=0, atol=0.1)


@pytest.mark.parametrize("device", DEVICES)
def test_originals_show_nothing_beyond_the_photo(device):
    camera = device.camera(POSED, SIZE)
    width, height = device.original_size(camera)
    corners = np.array([[0.5, 0.5], [camera.width - 0.5, camera.height - 0.5]])
    (left, top), (right, bottom) = device.distorted(corners, camera)
    assert left <= 1.0
    assert top <= 1.0
    assert right >= width - 1.0
    assert bottom >= height - 1.0


def test_visits_keep_the_list_and_add_to_it():
    own = (
        Session("01-01_10_00", 100.0, 30.0, 3.0, 0.0, 0.0),
        Session("02-02_10_00", 1.0, 2.0, 3.0, 0.0, 0.0, is_test=True),
    )
    more = with_visits(own, 12, np.random.default_rng(0))
    assert more[0] == own[0]
    assert more[-1] == own[1]
    assert len([s for s in more if not s.is_test]) == 12
    assert len({s.name for s in more}) == 13
    assert all(5 < s.sun_elevation_deg < 65 for s in more[1:-1])
    assert with_visits(own, 1, np.random.default_rng(0)) == own


@pytest.mark.slow
def test_originals_stand_in_a_colmap_folder(tmp_path):
    generate(
        "colonnade", 0, tmp_path / "s", size_px=(48, 32), train_views=4, test_views=1, samples=1,
        visits=2, num_devices=2, is_denoised=True, point_candidates=300, show_progress=False,
    )  # fmt: skip
    folder = tmp_path / "s" / "originals"
    lens = pycolmap.Reconstruction(str(folder / "sparse" / "0"))
    pinhole = pycolmap.Reconstruction(str(tmp_path / "s" / "undistorted" / "sparse" / "0"))
    assert {camera.model.name for camera in lens.cameras.values()} == {"SIMPLE_RADIAL"}
    assert len(lens.cameras) == len(pinhole.cameras) <= 2
    for image in lens.images.values():
        picture = cv2.imread(str(folder / "images" / image.name))
        assert picture.shape[:2] == (image.camera.height, image.camera.width)
    errors = [
        np.linalg.norm(lens.images[e.image_id].project_point(p.xyz) - _pixel(lens, e))
        for p in lens.points3D.values()
        for e in p.track.elements
    ]
    assert np.median(errors) < 0.5  # points carry the noise of a reconstruction


def _pixel(model: pycolmap.Reconstruction, element: pycolmap.TrackElement) -> np.ndarray:
    return model.images[element.image_id].points2D[element.point2D_idx].xy
