"""The sun from a sky's grading: skies that are painted for a known sun, and skies without one."""

from math import degrees

import pytest
import torch
from support.painted_sky import direction, seen_sky

from r3gw.lighting.cie_sky import clear_sky, covered_sky
from r3gw.training.sun_from_sky import sun_from_sky


@pytest.mark.parametrize(("elevation", "azimuth"), [(25.0, -110.0), (50.0, 140.0), (35.0, 80.0)])
def test_it_is_found_behind_and_beside_the_cameras(elevation, azimuth):
    sun = direction(elevation, azimuth)
    photos = [seen_sky(h, lambda d: 0.15 * clear_sky(d, sun).sum(dim=0)) for h in (-30.0, 25.0)]
    found = sun_from_sky(photos)
    assert found is not None
    assert degrees(float(torch.arccos((found @ sun).clamp(-1, 1)))) < 12.0


def test_a_covered_or_even_sky_says_nothing():
    for radiance_of in (lambda d: 0.2 * covered_sky(d), lambda d: torch.full_like(d[:, 0], 0.3)):
        assert sun_from_sky([seen_sky(0.0, radiance_of)]) is None
