"""The CIE's skies against values of the standard's own formula, and their integrals."""

from math import acos, cos, exp, pi, radians, sin

import numpy as np
import pytest
import torch

from r3gw.lighting import sh
from r3gw.lighting.cie_sky import clear_sky, covered_sky, sh_of_skies


def direction(elevation_deg: float, azimuth_deg: float) -> torch.Tensor:
    elevation, azimuth = radians(elevation_deg), radians(azimuth_deg)
    level = cos(elevation)
    return torch.tensor([level * sin(azimuth), -sin(elevation), level * cos(azimuth)])


def type_12(elevation_deg: float, azimuth_deg: float, sun_elevation_deg: float) -> float:
    """CIE S 011, equations 1 to 5, with the sun at azimuth 0, in zenith angles."""
    zenith, of_sun = radians(90 - elevation_deg), radians(90 - sun_elevation_deg)
    away = acos(cos(of_sun) * cos(zenith) + sin(of_sun) * sin(zenith) * cos(radians(azimuth_deg)))

    def gradation(angle: float) -> float:
        return 1 - exp(-0.32 / cos(angle))

    def scattering(angle: float) -> float:
        return 1 + 10 * (exp(-3 * angle) - exp(-3 * pi / 2)) + 0.45 * cos(angle) ** 2

    return scattering(away) * gradation(zenith) / (scattering(of_sun) * gradation(0.0))


@pytest.mark.parametrize("sun_deg", [10.0, 35.0, 60.0])
@pytest.mark.parametrize(("elevation", "azimuth"), [(90, 0), (20, 180), (5, 120), (50, 60)])
def test_a_clear_sky_is_that_of_the_standard(sun_deg, elevation, azimuth):
    found = clear_sky(direction(elevation, azimuth), direction(sun_deg, 0)).sum()
    assert float(found) == pytest.approx(type_12(elevation, azimuth, sun_deg), rel=1e-4, abs=0)


def test_it_is_brightest_at_the_sun_and_darkest_away_from_it_high_up():
    looks = torch.stack([direction(e, a) for e in range(2, 90, 4) for a in range(0, 360, 10)])
    sky, sun = clear_sky(looks, direction(30, 0)).sum(dim=0), direction(30, 0)
    assert float(looks[sky.argmax()] @ sun) > cos(radians(18))
    darkest = looks[sky.argmin()]
    assert float(-darkest[1]) > 0.5
    assert float(darkest[2]) < 0


def test_a_covered_sky_is_three_times_as_bright_overhead():
    looks = torch.stack([direction(0, 50), direction(90, 0), direction(30, 200)])
    torch.testing.assert_close(covered_sky(looks), torch.tensor([1.0, 3.0, 2.0]), rtol=1e-5, atol=0)


def test_integrals_over_the_upper_half():
    """Overcast: mean over solid angle 2, level irradiance 7 pi / 3 of the horizon's radiance."""
    shapes, level = sh_of_skies(direction(40, 70), 4)
    mean = shapes[2, 0] * (4 * pi) ** 0.5 / (2 * pi)
    assert float(mean) == pytest.approx(2.0, rel=2e-3, abs=0)
    assert float(level[2]) == pytest.approx(7 * pi / 3, rel=2e-3, abs=0)


def test_its_sh_are_those_of_random_samples():
    generator = np.random.default_rng(0)
    looks = generator.normal(size=(400_000, 3))
    looks /= np.linalg.norm(looks, axis=1, keepdims=True)
    looks[:, 1] = -np.abs(looks[:, 1])
    rays, sun = torch.from_numpy(looks).float(), direction(25, 110)
    clear = clear_sky(rays, sun).sum(dim=0)
    expected = 2 * pi * (clear[:, None] * sh.basis(rays, 4)).mean(dim=0)
    torch.testing.assert_close(
        sh_of_skies(sun, 4)[0][:2].sum(dim=0), expected, rtol=0.02, atol=0.05
    )
