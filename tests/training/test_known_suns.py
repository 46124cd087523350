"""Suns by date, time and place: the scene's yaw is found, wrong suns and clocks are told apart."""

from dataclasses import replace
from math import cos, degrees, radians, sin

import pytest
import torch
from support.flat_world import flat_photos, flat_points
from support.painted_sky import direction, seen_sky
from support.settings import train_settings

from r3gw.lighting.cie_sky import clear_sky, covered_sky
from r3gw.model.light_models.daylight import Daylight
from r3gw.scene.sun_position import SunPosition
from r3gw.training.known_suns import (
    TiedSuns,
    direction_of,
    suns_by_row,
    turned,
    yaw_by_skies,
    yaw_by_suns,
)
from r3gw.training.loop import train
from r3gw.training.start import initial_model

YAW = 217.0
POSITIONS = [(25.0, 100.0), (52.0, 175.0), (18.0, 250.0), (40.0, 140.0), (30.0, 210.0)]
KNOWN = torch.stack([direction(*each) for each in POSITIONS])


def test_a_position_is_a_direction_with_north_ahead():
    found = direction_of(SunPosition(elevation_deg=30.0, azimuth_deg=90.0))
    torch.testing.assert_close(
        found, torch.tensor([cos(radians(30)), -0.5, 0.0]), rtol=0, atol=1e-6
    )
    ahead = turned(torch.tensor([[0.0, 0.0, 1.0]]), 90.0)[0]
    torch.testing.assert_close(ahead, torch.tensor([1.0, 0.0, 0.0]), rtol=0, atol=1e-6)


def test_the_yaw_follows_the_many():
    """Two of five suns went wrong, as suns behind clouds and low suns do."""
    learned = turned(KNOWN, YAW)
    learned[1] = direction(70.0, 10.0)
    learned[4] = turned(KNOWN[4:], YAW + 60)[0]
    assert yaw_by_suns(KNOWN, learned, torch.ones(5)) == pytest.approx(YAW, rel=0, abs=1.0)


def test_clear_skies_tell_the_yaw():
    there = turned(KNOWN[:3], YAW)
    photos = [
        [seen_sky(YAW + 20.0, lambda d, sun=sun: 0.15 * clear_sky(d, sun).sum(dim=0))]
        for sun in there
    ]
    assert yaw_by_skies(list(KNOWN[:3]), photos) == pytest.approx(YAW, rel=0, abs=10.0)
    grey = [
        [replace(each, radiance=each.radiance.mean(-1, keepdim=True).expand(-1, 3))]
        for each in [seen_sky(0.0, lambda d: 0.2 * covered_sky(d))]
    ]
    assert yaw_by_skies([KNOWN[0]], grey) is None
    assert yaw_by_skies([None, KNOWN[0]], [photos[0], []]) is None


def daylight(learned: torch.Tensor, powers: list[float]) -> Daylight:
    light = Daylight(len(learned), 1.0, 0.2, 0.1, 0.75, 4)
    with torch.no_grad():
        light.sun_directions.copy_(2.5 * learned)
        light.log_sun_powers.copy_(torch.tensor(powers)[:, None].log().expand(-1, 3))
    return light


def test_suns_are_tied_but_where_a_clock_is_wrong(caplog):
    learned = turned(KNOWN, YAW)
    learned[0] = turned(KNOWN[:1], YAW + 3)[0]  # as well as suns are learned
    learned[2] = turned(KNOWN[2:3], YAW + 100)[0]  # strong, and nowhere near: its clock is wrong
    learned[4] = direction(60.0, 0.0)  # behind clouds: says nothing
    light = daylight(learned, [2.0, 2.0, 3.0, 2.0, 0.3])
    tied = TiedSuns()
    tied.solve(light, [*KNOWN])
    assert tied.yaw_deg == pytest.approx(YAW, rel=0, abs=3.5)
    assert list(tied.doubted) == [2]
    assert tied.doubted[2] > 60
    assert "clock or time zone wrong" in caplog.text
    assert sorted(tied.known) == [0, 1, 3, 4]
    assert TiedSuns.restored(tied.record()).record() == tied.record()
    only_night = TiedSuns()
    only_night.solve(light, [direction(-20.0, 0.0)])
    assert only_night.yaw_deg is None


def test_tied_suns_move_together():
    """Each step turns the sun that its photo lights; the yaw follows with all of them."""
    tied = TiedSuns(YAW, dict(enumerate(KNOWN)))
    light = daylight(turned(KNOWN, YAW), [1.0] * 5)
    for _ in range(200):
        with torch.no_grad():
            wanted = turned(KNOWN, YAW + 12)  # where photos pull them, half of them upwards, too
            wanted[::2, 1] -= 0.3
            light.sun_directions.add_(0.2 * (wanted - light.sun_directions))
        tied._move(light)
    assert tied.yaw_deg == pytest.approx(YAW + 12, rel=0, abs=0.5)
    there = turned(KNOWN, tied.yaw_deg)
    torch.testing.assert_close(light.sun_directions.detach(), there, rtol=0, atol=1e-6)


def test_photos_of_a_session_have_one_sun():
    pair = [direction(30.0, 100.0), direction(30.0, 104.0)]
    first, second, third = suns_by_row([0, 1, 0, 2], [pair[0], None, pair[1]])
    torch.testing.assert_close(first, direction(30.0, 102.0), rtol=0, atol=1e-3)
    assert second is None
    assert third is None


@pytest.mark.parametrize("north_deg", [0.0, 90.0])
def test_training_ties_what_is_known(north_deg):
    """From the iteration on at which the yaw is solved; where north lies must not matter."""
    settings = train_settings(
        iterations=60,
        model={"share_session_light": True},
        occlusion={"enabled": True, "voxels": 16, "directions": 16},
        daylight={"enabled": True, "suns": "known", "suns_tied_from": 20000},
        density={"reset_interval": None, "max_gaussians": 300},
    )
    suns = [direction(40.0, 150.0 + north_deg), direction(-10.0, 20.0 + north_deg)]
    photos = [replace(each, known_sun=sun) for each, sun in zip(flat_photos(), suns, strict=True)]
    skies = [photo.seen_sky for photo in photos]
    start = initial_model(flat_points(), ("a", "b"), settings, ("a", "b"), skies, suns=suns)
    state = train(start, photos, settings)
    light = state.model.appearance.light_model
    assert state.tied_suns.yaw_deg is not None
    there = turned(suns[0][None], state.tied_suns.yaw_deg)[0]
    torch.testing.assert_close(light.sun_directions[0].detach(), there, rtol=0, atol=1e-6)
    assert degrees(float(torch.arcsin(-there[1]))) == pytest.approx(40.0, rel=0, abs=1e-3)
    assert float(light.log_sun_powers[1].exp().max().detach()) < 1e-5
    assert sin(radians(40)) == pytest.approx(-float(there[1]), rel=0, abs=1e-5)
