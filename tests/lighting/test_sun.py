"""The sun that is found in a map, against suns that were put there; its SH against quadrature."""

from math import cos, pi, radians, sin

import numpy as np
import pytest
import torch

from r3gw.geometry.rotations import rotation_about_axis
from r3gw.lighting import envmap, sh
from r3gw.lighting.daylight import Sun, solid_angles, splat
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.lighting.sun import PointSun, sun_of_map

HEIGHT = 128
SUN = Sun(azimuth_deg=214.0, elevation_deg=37.0, turbidity=3.0)
IRRADIANCE = np.array([3.0, 2.6, 2.1])


def graded_sky() -> torch.Tensor:
    """A sky that is brighter towards the zenith, over darker ground."""
    up = -envmap.pixel_directions(HEIGHT, 2 * HEIGHT)[..., 1:2]
    sky = torch.where(up > 0, 0.4 + 0.1 * up, torch.full_like(up, 0.2))
    return sky * torch.tensor([0.8, 1.0, 1.3], dtype=torch.float64)


def test_a_sun_is_found_where_it_stands_with_its_energy():
    found = sun_of_map(graded_sky() + torch.from_numpy(splat(IRRADIANCE, SUN, HEIGHT)))
    assert found is not None
    expected = torch.from_numpy(SUN.direction).float()
    assert float(found.direction @ expected) > cos(radians(0.2))
    # The sky's gradient within fifteen degrees is what may differ.
    np.testing.assert_allclose(found.irradiance, IRRADIANCE, rtol=0.01, atol=0)


def test_what_is_split_off_and_what_stays_have_the_maps_energy():
    """Level irradiance, by a sum over pixels, of the sun alone and of the map less the sun."""
    sky, sun = graded_sky(), torch.from_numpy(splat(IRRADIANCE, SUN, HEIGHT))
    found = sun_of_map(sky + sun)
    assert found is not None
    up = (-envmap.pixel_directions(HEIGHT, 2 * HEIGHT)[..., 1:2]).clamp_min(0)
    level = torch.from_numpy(solid_angles(HEIGHT)) * up
    whole, rest = ((part * level).sum((0, 1)) for part in (sky + sun, sky))
    from_sun = found.irradiance.double() * sin(radians(SUN.elevation_deg))
    np.testing.assert_allclose(rest + from_sun, whole, rtol=0.01, atol=0)


def test_the_sh_of_map_and_sun_differ_by_the_skys():
    """`Light.sh_beside_point` is the projection of the map without its sun."""
    sky, sun = graded_sky(), torch.from_numpy(splat(IRRADIANCE, SUN, HEIGHT))
    light = Light.from_pixels((sky + sun).float())
    expected = Light.from_pixels(sky.float()).sh
    assert light.point is not None
    torch.testing.assert_close(light.sh_beside_point, expected, rtol=0, atol=0.03)
    assert float((light.sh - expected).abs().max()) > 1.0


@pytest.mark.parametrize("strength", [0.0, 0.02])
def test_a_grey_sky_has_no_sun(strength):
    faint = strength * torch.from_numpy(splat(IRRADIANCE, SUN, HEIGHT))
    assert sun_of_map(graded_sky() + faint) is None


def test_a_lamp_below_the_horizon_is_no_sun():
    below = Sun(azimuth_deg=214.0, elevation_deg=-20.0, turbidity=3.0)
    lamp = torch.from_numpy(splat(IRRADIANCE, below, HEIGHT))
    assert sun_of_map(graded_sky() + lamp) is None


def test_a_black_map_and_a_map_of_one_pixel_high_have_no_sun():
    assert sun_of_map(torch.zeros(16, 32, 3)) is None
    assert sun_of_map(torch.ones(1, 2, 3)) is None


def test_its_sh_are_those_of_a_small_bright_spot():
    pixels = torch.from_numpy(splat(IRRADIANCE, SUN, 256)).float()
    point = PointSun(torch.from_numpy(SUN.direction).float(), torch.from_numpy(IRRADIANCE).float())
    expected = envmap.project(pixels, envmap.pixel_directions(256, 512), 4)
    torch.testing.assert_close(point.sh(4), expected, rtol=0, atol=0.01)


def test_a_light_turns_and_scales_with_its_sun():
    point = PointSun(torch.tensor([0.6, -0.8, 0.0]), torch.tensor([2.0, 1.0, 0.5]))
    light = Light(point.sh(4) + sh.constant(0.3, 4), point=point)
    turn = rotation_about_axis(1, 0.7)
    turned = light.rotated(turn).times(2.0)
    assert turned.point is not None
    expected = (turn @ point.direction.double()).float()
    torch.testing.assert_close(turned.point.direction, expected, rtol=0, atol=1e-6)
    torch.testing.assert_close(turned.point.irradiance, 2 * point.irradiance, rtol=1e-6, atol=0)
    # Nothing but the even part is left beside the sun, however it is turned.
    rest = sh.constant(0.6, 4)
    torch.testing.assert_close(turned.sh_beside_point, rest, rtol=0, atol=1e-5)


def test_a_blend_lets_the_sun_walk():
    east, south = torch.tensor([1.0, 0.0, 0.0]), torch.tensor([0.0, 0.0, -1.0])
    sky = LearnedSky(torch.zeros(4, 3))
    first, last = (
        Light(p.sh(4) + sh.constant(0.3, 4), sky, p)
        for p in (PointSun(east, torch.full((3,), 2.0)), PointSun(south, torch.full((3,), 1.0)))
    )
    for weight in (0.0, 0.25, 1.0):
        mixed = first.blended(last, weight).point
        assert mixed is not None
        angle = weight * pi / 2
        expected = torch.tensor([cos(angle), 0.0, -sin(angle)])
        torch.testing.assert_close(mixed.direction, expected, rtol=0, atol=1e-6)
        level = torch.full((3,), 2.0 - weight)
        torch.testing.assert_close(mixed.irradiance, level, rtol=1e-6, atol=0)
    rest = first.blended(last, 0.4).sh_beside_point
    torch.testing.assert_close(rest, sh.constant(0.3, 4), rtol=0, atol=1e-5)
