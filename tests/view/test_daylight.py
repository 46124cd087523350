"""The tables of clear days against Mitsuba's model, and the formula that the page evaluates."""

from math import comb

import numpy as np
import pytest

from r3gw.geometry.cameras import UP
from r3gw.lighting.daylight import Sun, clear_sky, sun_irradiance
from r3gw.lighting.envmap import pixel_directions
from r3gw.view.daylight import daylight_tables, make_tables


def sky(sun: Sun, height: int) -> np.ndarray:
    """Hosek and Wilkie's formula over the tables, written anew in NumPy."""
    tables = daylight_tables()
    x = (sun.elevation_deg / 90) ** (1 / 3)
    bezier = np.array([comb(5, k) * (1 - x) ** (5 - k) * x**k for k in range(6)])
    low = min(int(sun.turbidity) - 1, 8)
    share = sun.turbidity - 1 - low

    def at(name):
        values = np.array(tables[name])
        return np.tensordot(bezier, (1 - share) * values[low] + share * values[low + 1], 1)

    a, b, c, d, e, f, g, h, i = at("params").T
    directions = pixel_directions(height, 2 * height).numpy()[: height // 2]
    up = directions @ np.array(UP)
    cosine = np.clip(directions @ sun.direction, -1, 1)[..., None]
    gamma, up = np.arccos(cosine), up[..., None]
    chi = (1 + cosine**2) / (1 + i**2 - 2 * i * cosine) ** 1.5
    glow = c + d * np.exp(e * gamma) + f * cosine**2 + g * chi + h * np.sqrt(up)
    return np.maximum((1 + a * np.exp(b / (up + 0.01))) * glow * at("radiance"), 0)


@pytest.mark.parametrize(
    "sun", [(150.0, 45.0, 3.0), (235.0, 6.0, 4.5), (10.0, 80.0, 1.0), (0.0, 0.5, 9.7)]
)
def test_the_sky_is_mitsubas(sun):
    expected = clear_sky(Sun(*sun), 16)[:8]
    np.testing.assert_allclose(sky(Sun(*sun), 16), expected, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("elevation", [2.0, 7.7, 20.3, 45.1, 88.0])
def test_the_sun_is_mitsubas_between_the_samples(elevation):
    samples = np.array(daylight_tables()["sunIrradiance"])
    position = np.sqrt(elevation / 90) * (samples.shape[1] - 1)
    low = int(position)
    share = position - low
    between = 0.5 * (samples[2] + samples[3])
    found = (1 - share) * between[low] + share * between[low + 1]
    expected = sun_irradiance(Sun(0.0, elevation, 3.5))
    np.testing.assert_allclose(found, expected, rtol=0.02, atol=0.02)


@pytest.mark.slow
def test_the_package_holds_the_tables_that_are_made():
    made, kept = make_tables(), daylight_tables()
    assert made.keys() == kept.keys()
    for name, values in made.items():
        np.testing.assert_allclose(values, kept[name], rtol=1e-6, atol=1e-9)
