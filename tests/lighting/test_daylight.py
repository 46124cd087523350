"""r3gw.lighting.daylight: where sky and sun are brightest, and what the ground sends back."""

import numpy as np
import pytest

from r3gw.lighting import envmap
from r3gw.lighting.daylight import Sun, clear_day, clear_sky, solid_angles

EAST_45 = (0.7071, -0.7071, 0.0)  # azimuth 90 is +x, up is -y
BEHIND_20 = (0.0, -0.3420, -0.9397)


@pytest.mark.parametrize(
    ("azimuth", "elevation", "towards"), [(90.0, 45.0, EAST_45), (180.0, 20.0, BEHIND_20)]
)
def test_sky_and_sun_are_brightest_at_the_sun(azimuth, elevation, towards):
    sun = Sun(azimuth, elevation, 3.0)
    np.testing.assert_allclose(sun.direction, towards, rtol=0, atol=1e-4)
    looks = envmap.pixel_directions(64, 128).numpy().reshape(-1, 3)
    disc = looks[clear_day(sun, 64).sum(-1).argmax()]
    assert np.degrees(np.arccos(disc @ np.array(towards))) < 2.0
    # Haze makes the horizon below the sun the sky's brightest place: its azimuth is the sun's.
    glow = looks[clear_sky(sun, 64).sum(-1).argmax()]
    assert np.degrees(np.arctan2(glow[0], glow[2])) % 360 == pytest.approx(azimuth, abs=4.0)


def test_the_ground_reflects_what_falls_on_it():
    day = clear_day(Sun(40.0, 50.0, 3.0), 32)
    up = -envmap.pixel_directions(32, 64).numpy()[..., 1:2]
    received = (day * solid_angles(32) * up)[:16].sum((0, 1))
    np.testing.assert_allclose(day[20, 7] * np.pi / received, (0.24, 0.23, 0.2), rtol=1e-6, atol=0)
