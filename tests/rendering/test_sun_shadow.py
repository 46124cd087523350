"""Shadows of a known roof over known ground: their edges by geometry."""

from math import cos, radians, sin, tan

import pytest
import torch

from r3gw.geometry.cameras import Camera
from r3gw.rendering.sun_shadow import Gaussians, reach, sun_shadow

SPACING = 0.05
ROOF_HEIGHT, ROOF_HALF = 1.5, 0.8  # a square roof over the middle of the ground, up is -y
GROUND_HALF = 4.0


def level_sheet(height: float, half: float) -> torch.Tensor:
    """Points of a level square about the origin."""
    steps = torch.arange(-half, half + SPACING / 2, SPACING)
    x, z = torch.meshgrid(steps, steps, indexing="ij")
    return torch.stack([x, torch.full_like(x, -height), z], dim=-1).reshape(-1, 3)


def roof_and_ground() -> Gaussians:
    means = torch.cat([level_sheet(0.0, GROUND_HALF), level_sheet(ROOF_HEIGHT, ROOF_HALF)])
    count = len(means)
    quaternions = torch.tensor([1.0, 0.0, 0.0, 0.0]).expand(count, 4).contiguous()
    scales = torch.tensor([0.6 * SPACING, 0.002, 0.6 * SPACING]).expand(count, 3).contiguous()
    return Gaussians(means, quaternions, scales, torch.full((count,), 0.9))


def shadow_of_roof(elevation_deg: float, azimuth_deg: float):
    elevation, azimuth = radians(elevation_deg), radians(azimuth_deg)
    sun = torch.tensor(
        [cos(elevation) * sin(azimuth), -sin(elevation), cos(elevation) * cos(azimuth)]
    )
    return sun_shadow(roof_and_ground(), sun)


@pytest.mark.parametrize("elevation", [35.0, 60.0])
@pytest.mark.parametrize("azimuth", [0.0, 90.0, 180.0])
def test_the_edge_lies_where_geometry_puts_it(elevation, azimuth):
    """Along the line through the middle, away from the sun, to 2 % of the ground's side."""
    shadow = shadow_of_roof(elevation, azimuth)
    away = -torch.tensor([sin(radians(azimuth)), 0.0, cos(radians(azimuth))])
    along = torch.arange(-2.0, 3.9, 0.01)
    lit = shadow.visibility(along[:, None] * away)
    shift = ROOF_HEIGHT / tan(radians(elevation))
    inside = along[lit < 0.5]
    tolerance = 0.02 * 2 * GROUND_HALF
    assert float(inside.min()) == pytest.approx(shift - ROOF_HALF, rel=0, abs=tolerance)
    assert float(inside.max()) == pytest.approx(shift + ROOF_HALF, rel=0, abs=tolerance)
    # Well inside it is dark, well outside it is light.
    is_deep = (along - shift).abs() < ROOF_HALF - 0.25
    is_out = (along - shift).abs() > ROOF_HALF + 0.25
    assert float(lit[is_deep].max()) < 0.15
    assert float(lit[is_out].min()) > 0.9


def test_the_roof_itself_is_in_the_sun():
    shadow = shadow_of_roof(40.0, 30.0)
    assert float(shadow.visibility(level_sheet(ROOF_HEIGHT, ROOF_HALF - 0.1)).min()) > 0.9


def test_what_lies_outside_sees_the_sun():
    shadow = shadow_of_roof(40.0, 30.0)
    far = torch.tensor([[50.0, 0.0, 0.0], [0.0, 0.0, -60.0], [0.0, 30.0, 0.0]])
    lit = shadow.visibility(far)
    torch.testing.assert_close(lit[:2], torch.ones(2), rtol=0, atol=1e-6)


def test_pixels_are_as_lit_as_the_points_that_they_show():
    shadow = shadow_of_roof(50.0, 20.0)
    camera = Camera.looking_at([0.0, 0.0, 0.0], position=[0.5, -6.0, -3.0], width=40, height=30)
    points = torch.tensor([[1.0, 0.0, 0.4], [-0.4, 0.0, -1.2], [-0.6, 0.0, -1.4]])
    local = points.double() @ camera.cam_from_world[:3, :3].T + camera.cam_from_world[:3, 3]
    fx, fy, cx, cy = camera.intrinsics
    for point, place in zip(points, local.tolist(), strict=True):
        # A camera of one pixel whose centre shows the point.
        column, row = fx * place[0] / place[2] + cx, fy * place[1] / place[2] + cy
        one = Camera(camera.cam_from_world, (fx, fy, cx - column + 0.5, cy - row + 0.5), 1, 1)
        is_covered = torch.ones(1, 1, dtype=torch.bool)
        found = shadow.seen_from(one, torch.tensor([[place[2]]]).float(), is_covered)
        expected = shadow.visibility(point[None])
        torch.testing.assert_close(found[0], expected, rtol=0, atol=0.02)


def test_an_empty_scene_and_a_vertical_sun():
    unseen = Gaussians(
        torch.zeros(1, 3),
        torch.tensor([[1.0, 0.0, 0.0, 0.0]]),
        torch.full((1, 3), 0.1),
        torch.zeros(1),
    )
    nothing = sun_shadow(unseen, torch.tensor([0.0, -1.0, 0.0]))
    lit = nothing.visibility(torch.tensor([[0.0, 1.0, 0.0]]))
    torch.testing.assert_close(lit, torch.ones(1), rtol=0, atol=1e-6)


def test_a_gaussian_is_as_lit_as_the_pixels_that_show_it():
    """On a grid of small Gaussians: those of the ground in the roof's shadow, and the others."""
    gaussians, shadow = roof_and_ground(), shadow_of_roof(50.0, 90.0)
    camera = Camera.looking_at([0.0, 0.0, 0.1], position=[0.0, -7.0, 0.0], width=120, height=120)
    found = reach(gaussians, [camera], shadow)
    shift, means = ROOF_HEIGHT / tan(radians(50.0)), gaussians.means
    is_ground = means[:, 1] == 0
    along = (means[:, 0] + shift).abs()  # the sun stands at +x, so the shadow falls to -x
    # Beside what the roof hides from a camera high above.
    is_seen = means[:, 0] < -ROOF_HALF * 7.0 / (7.0 - ROOF_HEIGHT) - 0.15
    is_deep = is_ground & is_seen & (along < ROOF_HALF - 0.3) & (means[:, 2].abs() < 0.4)
    is_out = is_ground & (means[:, 0] > 1.5) & (means.abs().amax(dim=-1) < 2.5)
    assert int(is_deep.sum()) > 20
    assert float(found[is_deep].max()) < 0.15
    assert float(found[is_out].min()) > 0.9


def test_what_no_camera_sees_is_as_lit_as_its_middle():
    gaussians, shadow = roof_and_ground(), shadow_of_roof(50.0, 90.0)
    away = Camera.looking_at([0.0, -9.0, 50.0], position=[0.0, -9.0, 20.0], width=8, height=8)
    found = reach(gaussians, [away], shadow)
    torch.testing.assert_close(found, shadow.visibility(gaussians.means), rtol=0, atol=0)
