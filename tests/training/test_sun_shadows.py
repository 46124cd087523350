"""Shadow maps while a run trains: when they are cast, how many are kept, also by a checkpoint."""

import pytest
import torch
from support.settings import train_settings

from r3gw.lighting.sun import PointSun
from r3gw.rendering.sun_shadow import reach_in, shadow_in
from r3gw.training import sun_shadows
from r3gw.training.schedule import Schedule
from r3gw.training.sun_shadows import SunShadows

SUN = PointSun(torch.tensor([0.6, -0.8, 0.0]), torch.ones(3))
SCHEDULE = Schedule.of(train_settings(iterations=4000))  # shadows from 400 on, of 100 iterations


# The same, where what reaches Gaussians is found in every iteration, or kept for 300.
ALWAYS = Schedule.of(train_settings(iterations=4000, daylight={"reach_age": 1}))
LATER = Schedule.of(train_settings(iterations=4000, daylight={"reach_age": 3000}))


@pytest.fixture
def sunny(model):
    """The fixture's two photos, and a third."""
    model.appearance.rows = (0, 1, 1)
    return model


def test_they_are_cast_from_the_first_shadows_on_and_when_they_are_old(sunny, camera):
    shadows = SunShadows()
    assert shadows.of(sunny, 0, camera, SUN, 399, ALWAYS).reached is None
    assert not shadows.cast
    shadows.of(sunny, 0, camera, SUN, 400, ALWAYS)
    first = shadows.cast[0]
    shadows.of(sunny, 0, camera, SUN, 499, ALWAYS)
    assert shadows.cast[0] is first
    shadows.of(sunny, 0, camera, SUN, 500, ALWAYS)
    since, second = shadows.cast[0]
    assert since == 500
    torch.testing.assert_close(second.depth, first[1].depth, rtol=0, atol=0)


def test_photos_of_a_row_share_its_map(sunny, camera):
    shadows = SunShadows()
    for photo in (0, 1, 2):
        shadows.of(sunny, photo, camera, SUN, 400 + photo, SCHEDULE)
    assert {row: since for row, (since, _) in shadows.cast.items()} == {0: 400, 1: 401}


def test_what_reaches_the_gaussians_is_what_the_map_says(sunny, camera):
    """To half of one of the 255 steps in which it is kept."""
    found = SunShadows().of(sunny, 0, camera, SUN, 400, SCHEDULE).reached
    expected = reach_in(sunny, camera, shadow_in(sunny, SUN.direction))
    assert float(expected.std()) > 0.05
    torch.testing.assert_close(found, expected, rtol=0, atol=0.5 / 255 + 1e-6)


def test_it_is_kept_until_it_is_old_or_gaussians_come_or_go(sunny, camera):
    shadows = SunShadows()
    first = shadows.of(sunny, 0, camera, SUN, 400, LATER).reached
    sunny.foreground["means"].data += 0.5 * torch.rand(
        sunny.foreground["means"].shape, generator=torch.Generator().manual_seed(2)
    )
    kept = shadows.of(sunny, 0, camera, SUN, 699, LATER).reached
    torch.testing.assert_close(kept, first, rtol=0, atol=0)
    other = shadows.of(sunny, 1, camera, SUN, 699, LATER).reached
    assert float((other - first).abs().max()) > 0.05
    old = shadows.of(sunny, 0, camera, SUN, 700, LATER).reached
    torch.testing.assert_close(old, other, rtol=0, atol=1e-6)
    shadows.forget_reached()
    assert not shadows.reached


@pytest.mark.parametrize(("moved_deg", "is_kept"), [(0.8, True), (1.2, False)])
def test_it_is_found_anew_where_the_sun_has_moved(sunny, camera, moved_deg, is_kept):
    shadows = SunShadows()
    shadows.of(sunny, 0, camera, SUN, 400, LATER)
    angle = torch.tensor(moved_deg).deg2rad()
    across = torch.tensor([0.8, 0.6, 0.0])
    moved = PointSun(angle.cos() * SUN.direction + angle.sin() * across, SUN.irradiance)
    shadows.of(sunny, 0, camera, moved, 420, LATER)
    assert shadows.reached[0].since == (400 if is_kept else 420)


def test_the_oldest_go_first(sunny, camera, monkeypatch):
    monkeypatch.setattr(sun_shadows, "MOST_KEPT", 2)
    sunny.appearance.rows = (5, 3, 4)
    shadows = SunShadows()
    for photo in (0, 1, 2):
        shadows.of(sunny, photo, camera, SUN, 400 + photo, SCHEDULE)
    assert set(shadows.cast) == {3, 4}


def test_a_checkpoint_keeps_them(sunny, camera):
    sunny.appearance.rows = (2, 10)
    shadows = SunShadows()
    for photo in (0, 1):
        shadows.of(sunny, photo, camera, SUN, 450 + photo, SCHEDULE)
    again = SunShadows.restored(shadows.tensors(), shadows.record())
    assert set(again.cast) == {2, 10}
    points = sunny.foreground["means"].detach()
    for row, (since, shadow) in shadows.cast.items():
        assert again.cast[row][0] == since
        found, expected = (each.visibility(points) for each in (again.cast[row][1], shadow))
        torch.testing.assert_close(found, expected, rtol=0, atol=0)
    assert set(again.reached) == {0, 1}
    for photo, kept in shadows.reached.items():
        assert again.reached[photo].since == kept.since
        torch.testing.assert_close(again.reached[photo].sun, kept.sun, rtol=0, atol=0)
        torch.testing.assert_close(again.reached[photo].shares, kept.shares, rtol=0, atol=0)
