"""r3gw.relight.uncovered: pixels for which what must be seen is plain."""

import pytest
import torch

from r3gw.relight.uncovered import other_sky_seen, own_sky_behind


def pixel(value: float) -> torch.Tensor:
    """One pixel."""
    return torch.full((1, 1, 1), value)


@pytest.mark.parametrize(
    ("foreground", "sky", "dark", "own", "other"),
    [
        (0.0, 0.0, 0.0, 1.0, 1.0),  # nothing anywhere: sky
        (1.0, 0.0, 0.0, 0.0, 0.0),  # a wall
        (0.7, 0.0, 0.0, 0.0123, 0.0123),  # dark ground with holes: hardly a veil
        (0.0, 0.8, 0.0, 0.2, 1.0),  # thin sky
        (0.0, 0.5, 1.0, 0.0, 0.75),  # a cloud of the photo's own: none of another sky
        (0.0, 0.1, 1.0, 0.0, 0.1),  # leaves that are left out of the sky
        (0.0, 0.1, 0.0, 0.9, 1.0),  # the same from afar
        (0.5, 0.4, 0.0, 0.0462, 0.4462),  # a leaf before the sky
    ],
)
def test_what_shows_the_sky(foreground, sky, dark, own, other):
    planes = (pixel(foreground), pixel(sky), pixel(dark))
    assert own_sky_behind(*planes).item() == pytest.approx(own, abs=1e-4)
    assert other_sky_seen(*planes).item() == pytest.approx(other, abs=1e-4)


def test_weights_are_shares_of_what_the_foreground_leaves():
    random = torch.Generator().manual_seed(0)
    foreground, of_rest, dark = torch.rand(3, 200, 200, 1, generator=random)
    sky = (1 - foreground) * of_rest
    own, other = (w(foreground, sky, dark) for w in (own_sky_behind, other_sky_seen))
    assert (own >= 0).all()
    assert (own <= 1 - foreground - sky + 1e-6).all()
    assert (other >= sky - 1e-6).all()
    assert (other <= 1 - foreground + 1e-6).all()
