"""r3gw.relight.cameras: paths meet their photos, orbits keep looking at the middle."""

from math import cos, pi, sin

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.relight.cameras import CameraOptions, cameras_over_time, focus, orbited, path
from r3gw.relight.sweep import Sweep
from r3gw.scene import load_scene


def camera(
    centre, turn_deg=(0.0, 0.0, 0.0), focal=100.0, size=(80, 60), principal=(40.0, 30.0)
) -> Camera:
    """A camera at ``centre``, turned about x, y, z from looking along +z."""
    rotation = Rotation.from_euler("xyz", turn_deg, degrees=True).as_matrix().T
    cam_from_world = torch.eye(4, dtype=torch.float64)
    cam_from_world[:3, :3] = torch.from_numpy(rotation)
    cam_from_world[:3, 3] = torch.from_numpy(-rotation @ np.array(centre, dtype=float))
    return Camera(cam_from_world, (focal, focal, *principal), *size)


def pixel(of: Camera, point: torch.Tensor) -> np.ndarray:
    """Where a world point appears, in pixels."""
    local = of.cam_from_world[:3, :3] @ point + of.cam_from_world[:3, 3]
    assert local[2] > 0
    fx, fy, cx, cy = of.intrinsics
    return np.array([float(fx * local[0] / local[2] + cx), float(fy * local[1] / local[2] + cy)])


STOPS = [
    camera((0, 0, 0)),
    camera((2, -0.3, 0.5), (5, -20, 1), 130.0, principal=(42.0, 29.0)),
    camera((5, 0, 2), (0, -50, -2), 90.0),
]


def test_path_passes_through_its_photos():
    steps = np.sqrt([np.linalg.norm([2, 0.3, 0.5]), np.linalg.norm([3, 0.3, 1.5])])
    shares = [0.0, float(steps[0] / steps.sum()), 1.0]
    for found, stop in zip(path(STOPS, shares), STOPS, strict=True):
        torch.testing.assert_close(found.cam_from_world, stop.cam_from_world, rtol=0, atol=1e-9)
        np.testing.assert_allclose(found.intrinsics, stop.intrinsics, rtol=1e-9, atol=0)


def test_path_is_smooth_and_rigid():
    shares = np.linspace(0, 1, 201).tolist()
    found = path(STOPS, shares)
    centres = np.stack([each.centre.numpy() for each in found])
    steps = np.diff(centres, axis=0)
    assert np.abs(np.diff(steps, axis=0)).max() < 0.05 * np.abs(steps).max()
    for each in found:
        rotation = each.cam_from_world[:3, :3]
        torch.testing.assert_close(
            rotation @ rotation.T, torch.eye(3, dtype=torch.float64), rtol=0, atol=1e-12
        )
        assert 90.0 - 1e-9 <= each.intrinsics[0] <= 130.0 + 1e-9


def test_two_photos_make_a_straight_line_and_even_turn():
    first, last = camera((0, 0, 0)), camera((4, 0, 0), (0, 40, 0))
    middle = path([first, last], [0.5])[0]
    torch.testing.assert_close(
        middle.centre, torch.tensor([2.0, 0, 0], dtype=torch.float64), rtol=0, atol=1e-9
    )
    half = camera((2, 0, 0), (0, 20, 0))
    torch.testing.assert_close(middle.cam_from_world, half.cam_from_world, rtol=0, atol=1e-9)


def test_photos_from_one_spot_and_of_other_sizes_are_a_path_too():
    turned = camera((0, 0, 0), (0, 30, 0), focal=200.0, size=(60, 120), principal=(30.0, 60.0))
    found = path([camera((0, 0, 0)), turned], [0.0, 0.5, 1.0])
    assert all(torch.isfinite(each.cam_from_world).all() for each in found)
    assert {(each.width, each.height) for each in found} == {(80, 60)}
    # The same angle from top to bottom: 120 px at 200 px are 60 px at 100 px.
    np.testing.assert_allclose(found[-1].intrinsics, (100, 100, 40, 30), rtol=1e-9, atol=0)


@pytest.mark.parametrize("turn", [-2.5, -0.7, 0.0, 0.4, pi])
def test_orbit_keeps_looking_at_the_middle(turn):
    centre = torch.tensor([1.0, -2.0, 9.0], dtype=torch.float64)
    start = camera((0.5, 0.2, 1.0), (10, 7, 3), principal=(43.0, 28.0))
    carried = orbited(start, centre, turn)
    np.testing.assert_allclose(pixel(carried, centre), (43.0, 28.0), rtol=0, atol=1e-9)
    before, after = start.centre - centre, carried.centre - centre
    torch.testing.assert_close(after.norm(), before.norm(), rtol=1e-12, atol=0)
    torch.testing.assert_close(after[1], before[1], rtol=0, atol=1e-12)
    level = before[[0, 2]] / before[[0, 2]].norm(), after[[0, 2]] / after[[0, 2]].norm()
    assert float(level[0] @ level[1]) == pytest.approx(cos(turn), abs=1e-9)
    # Upright: a point straight above the middle is straight above it in the picture.
    above = pixel(carried, centre + torch.tensor([0.0, -0.1, 0.0]))
    assert above[0] == pytest.approx(43.0, abs=1e-6)
    assert above[1] < 28.0


def test_positive_orbits_go_to_the_right():
    centre = torch.tensor([0.0, 0.0, 10.0], dtype=torch.float64)
    carried = orbited(camera((0, 0, 0)), centre, 0.3)
    expected = torch.tensor([10 * sin(0.3), 0.0, 10 - 10 * cos(0.3)], dtype=torch.float64)
    torch.testing.assert_close(carried.centre, expected, rtol=0, atol=1e-12)


def test_focus_is_where_axes_meet():
    target = torch.tensor([0.3, -1.0, 8.0], dtype=torch.float64)
    prior = torch.tensor([5.0, 5.0, 5.0])
    around = [orbited(camera((0, 0, 0)), target, turn) for turn in (-0.5, 0.0, 0.6)]
    torch.testing.assert_close(focus(around, prior), target, rtol=0, atol=0.2)
    parallel = [camera((x, 0, 0)) for x in (-1, 0, 1)]  # all look along +z
    found = focus(parallel, torch.tensor([0.0, 0.0, 7.0]))
    expected = torch.tensor([0.0, 0.0, 7.0], dtype=torch.float64)
    torch.testing.assert_close(found, expected, rtol=0, atol=1e-6)


def test_choices(tiny):
    scene, middle = load_scene(tiny.folder), torch.tensor([0.0, 0.0, 6.0])
    still = cameras_over_time(scene, CameraOptions(("a_0",), width_px=96), middle, [0.0, 1.0])
    assert [(each.width, each.height) for each in still] == [(96, 64)] * 2
    assert still[0].intrinsics == (90.0, 90.0, 48.0, 32.0)
    orbit = CameraOptions(("a_0",), Sweep((-20.0, 20.0)))
    found = cameras_over_time(scene, orbit, middle, [0.0, 1.0])
    assert found[0].centre[0] < found[1].centre[0]
    with pytest.raises(InputError, match="one view, but 2"):
        cameras_over_time(scene, CameraOptions(("a_0", "a_1"), Sweep((0.0,))), middle, [0.0])
