"""r3gw.relight.seen: photos of a flat wall, whose places are known."""

from dataclasses import replace
from math import cos, radians, sin

import pytest
import torch
from support.blob import blob_gaussians

from r3gw.geometry.cameras import Camera
from r3gw.relight.gaussians import Relightable
from r3gw.relight.seen import Coverage, dimmed, remark

DISTANCE = 6.0


@pytest.fixture(scope="module")
def wall() -> Relightable:
    """A wall of solid flat Gaussians at z = 0, 2 by 2 units, before a sky."""
    gaussians = blob_gaussians()
    count = gaussians.num_foreground
    x, y = torch.meshgrid(torch.linspace(-1, 1, 38), torch.linspace(-1, 1, 40), indexing="xy")
    means, log_scales = gaussians.means.clone(), gaussians.log_scales.clone()
    quaternions = gaussians.quaternions.clone()
    places = torch.stack([x, y, torch.zeros_like(x)], dim=-1).reshape(-1, 3)[:count]
    means[:count], log_scales[:count] = places, torch.tensor([-2.8, -2.8, -7.0])
    quaternions[:count] = torch.tensor([1.0, 0.0, 0.0, 0.0])
    return replace(
        gaussians,
        means=means,
        log_scales=log_scales,
        quaternions=quaternions,
        opacity_logits=torch.full_like(gaussians.opacity_logits, 5.0),
    )


def at(turn_deg: float, towards: float = 0.0, fov_deg: float = 30.0) -> Camera:
    """A camera before the wall, carried about its middle; ``towards`` shifts where it looks."""
    turn = radians(turn_deg)
    place = (DISTANCE * sin(turn), 0.0, -DISTANCE * cos(turn))
    return Camera.looking_at(
        (towards, 0.0, 0.0), position=place, fov_deg=fov_deg, width=96, height=96
    )


@pytest.mark.parametrize(
    ("photos", "turn_deg", "share"),
    [
        ((-10.0, 10.0), 0.0, 1.0),
        ((0.0,), 0.0, 0.0),  # one photo fixes no place
        ((-10.0, 10.0), 15.0, 1.0),  # 25 degrees from the further one
        ((-10.0, 10.0), 50.0, 0.0),  # 40 and 60 degrees away
        ((-10.0, 10.0, 12.0), 45.0, 0.0),
        ((-10.0, 20.0, 22.0), 45.0, 1.0),
        ((), 0.0, 0.0),
    ],
)
def test_two_photos_from_within_thirty_degrees(wall, photos, turn_deg, share):
    coverage = Coverage(wall, [at(turn) for turn in photos])
    assert coverage.share(at(turn_deg)) == pytest.approx(share, abs=0.02)


def test_what_no_photo_has_in_its_frame_is_guessed(wall):
    """Two photos that show the wall's right half alone."""
    photos = [at(turn, towards=1.0, fov_deg=19.0) for turn in (-5.0, 5.0)]
    coverage = Coverage(wall, photos)
    well, surfaces = coverage.planes(at(0.0))
    left, right = slice(20, 44), slice(54, 76)
    assert well[40:56, left].max() < 0.02
    torch.testing.assert_close(well[40:56, right], surfaces[40:56, right], rtol=0, atol=0.02)
    assert 0.4 < coverage.share(at(0.0)) < 0.6


def test_what_something_hides_is_not_seen(wall):
    """The same wall once more behind the first: photos from the front see the first alone."""
    behind = wall.means.clone()
    behind[: wall.num_foreground : 2, 2] = 1.5
    coverage = Coverage(replace(wall, means=behind), [at(-10.0), at(10.0)])
    is_well = coverage.is_well_seen(at(0.0).centre)
    assert is_well[1::2].float().mean() > 0.98
    assert is_well[::2].float().mean() < 0.1


def test_the_sky_alone_has_no_share(wall):
    away = Camera.looking_at((0.0, -3.0, -9.0), position=(0.0, 0.0, -6.0), width=32, height=32)
    assert Coverage(wall, [at(0.0)]).share(away) is None


def test_guessed_surfaces_become_dark_and_grey():
    colours = torch.tensor([0.9, 0.5, 0.1]).expand(2, 3)
    shown = dimmed(colours, torch.tensor([True, False]))
    torch.testing.assert_close(shown[0], colours[0], rtol=0, atol=0)
    torch.testing.assert_close(shown[1], torch.tensor([0.21, 0.175, 0.14]), rtol=0, atol=1e-6)


def test_a_remark_where_most_is_guessed():
    assert remark(None) is None
    assert remark(0.5) is None
    assert remark(0.234) == (
        "23 % of the surfaces in view were seen by 2 photos from within 30 degrees; the rest is "
        "guessed"
    )
