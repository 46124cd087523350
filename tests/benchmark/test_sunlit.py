"""Truth about sun and shadow: a wall on level ground, by geometry."""

from math import atan2, cos, degrees, radians, sin, tan

import mitsuba as mi
import numpy as np
import pytest

from r3gw.benchmark.sunlit import EDGE_PX, faces_sun, in_sun, shadow_edges
from r3gw.geometry.cameras import Camera, pixel_rays

CAMERA = Camera.looking_at(
    [0.0, 0.0, 0.001], position=[0.0, -12.0, 0.0], fov_deg=50.0, width=60, height=50
)
WALL = 1.5  # high, across x, at z = 0


def place() -> mi.Scene:
    transform = mi.ScalarTransform4f
    return mi.load_dict(
        {
            "type": "scene",
            "ground": {
                "type": "rectangle",
                "to_world": transform().rotate([1, 0, 0], 90).scale(50),
            },
            "wall": {
                "type": "rectangle",
                "to_world": transform().translate([0, -WALL / 2, 0]).scale([50, WALL / 2, 1]),
            },
        }
    )


@pytest.mark.parametrize("elevation", [30.0, 55.0])
def test_a_walls_shadow_ends_where_geometry_puts_it(elevation):
    """The sun stands at +z, so the shadow falls to -z, as long as the wall over the tangent."""
    sun = np.array([0.0, -sin(radians(elevation)), cos(radians(elevation))])
    pose = CAMERA.cam_from_world.numpy()
    rays = pixel_rays(CAMERA).numpy() @ pose[:3, :3]
    depth = np.full((50, 60), 12.0)  # level ground straight below
    points = rays * 12.0 + CAMERA.centre.numpy()
    normal = np.broadcast_to(np.array([0.0, -1.0, 0.0]), (50, 60, 3))
    reached = in_sun(place(), CAMERA, depth, normal, sun)
    length = WALL / tan(radians(elevation))
    inner = np.abs(points[..., 2]) > 0.2  # the wall itself is seen edge on
    expected = (points[..., 2] > 0) | (points[..., 2] < -length)
    pixel = 12.0 * (2 * tan(radians(25)) / 60)
    near = np.abs(points[..., 2] + length) < pixel
    np.testing.assert_array_equal(reached[inner & ~near], expected[inner & ~near])
    facing = faces_sun(normal, sun)
    assert facing.all()
    edge = shadow_edges(reached, facing)
    rows = np.nonzero(edge[:, 30])[0]
    assert 2 * (2 * EDGE_PX) <= len(rows) <= 2 * (2 * EDGE_PX + 2)
    assert degrees(atan2(WALL, length)) == pytest.approx(elevation)


def test_a_surface_that_turns_away_has_no_cast_shadow():
    facing = np.zeros((20, 20), np.bool_)
    facing[:, :10] = True
    assert not shadow_edges(facing, facing).any()
    assert not shadow_edges(np.zeros_like(facing), facing).any()
