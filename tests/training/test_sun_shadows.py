"""Shadow maps while a run trains: when they are cast, how many are kept, also by a checkpoint."""

import torch
from support.settings import train_settings

from r3gw.lighting.sun import PointSun
from r3gw.training import sun_shadows
from r3gw.training.schedule import Schedule
from r3gw.training.sun_shadows import SunShadows

SUN = PointSun(torch.tensor([0.6, -0.8, 0.0]), torch.ones(3))
SCHEDULE = Schedule.of(train_settings(iterations=4000))  # shadows from 400 on, of 100 iterations


def test_they_are_cast_from_the_first_shadows_on_and_when_they_are_old(model):
    shadows = SunShadows()
    assert shadows.of(model, 0, SUN, 399, SCHEDULE).shadow is None
    first = shadows.of(model, 0, SUN, 400, SCHEDULE).shadow
    assert shadows.of(model, 0, SUN, 499, SCHEDULE).shadow is first
    assert shadows.of(model, 1, SUN, 499, SCHEDULE).shadow is not first
    second = shadows.of(model, 0, SUN, 500, SCHEDULE).shadow
    assert second is not first
    torch.testing.assert_close(second.depth, first.depth, rtol=0, atol=0)


def test_the_oldest_go_first(model, monkeypatch):
    monkeypatch.setattr(sun_shadows, "MOST_KEPT", 2)
    shadows = SunShadows()
    for iteration, row in ((400, 5), (401, 3), (402, 4)):
        shadows.of(model, row, SUN, iteration, SCHEDULE)
    assert set(shadows.cast) == {3, 4}


def test_a_checkpoint_keeps_them(model):
    shadows = SunShadows()
    for row in (2, 10):
        shadows.of(model, row, SUN, 450 + row, SCHEDULE)
    again = SunShadows.restored(shadows.tensors(), shadows.record())
    assert set(again.cast) == {2, 10}
    points = model.foreground["means"].detach()
    for row, (since, shadow) in shadows.cast.items():
        assert again.cast[row][0] == since
        found, expected = (each.visibility(points) for each in (again.cast[row][1], shadow))
        torch.testing.assert_close(found, expected, rtol=0, atol=0)
