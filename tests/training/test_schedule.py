"""One function scales every milestone; the paper's own length leaves them as printed."""

import pytest
from support.settings import train_settings

from r3gw.training.schedule import Schedule, scaled


def test_the_papers_length_keeps_its_numbers():
    schedule = Schedule.of(train_settings())
    assert schedule == Schedule(
        *(40000, 500, 2000, 500, 15000, 500, 3000, 30000, 30000, 4000, 6000, 1000, 4000),
        5000,
        1.0,
        0,
        8000,
        4000,
    )


def test_a_short_run_scales_all():
    schedule = Schedule.of(train_settings(iterations=4000))
    assert schedule == Schedule(
        4000, 50, 200, 50, 1500, 50, 300, 3000, 3000, 400, 600, 100, 400, 500, 1.0, 0, 800, 400
    )


@pytest.mark.parametrize(("n", "expected"), [(0, 0), (1, 1), (500, 1), (20000, 20)])
def test_scaled_never_loses_a_milestone(n, expected):
    assert scaled(n, 40, 40000) == expected


def test_events():
    schedule = Schedule.of(train_settings(iterations=4000))
    assert [i for i in range(1, 4001) if schedule.densifies(i)] == list(range(50, 1501, 50))
    assert [i for i in range(1, 4001) if schedule.resets_opacity(i)] == [50, 300, 600, 900, 1200]
    assert schedule.density_progress(50) == 0.0
    assert schedule.density_progress(1500) == 1.0
    assert not schedule.prunes_huge(300)
    assert schedule.prunes_huge(301)


def test_shadows_are_cast_at_intervals_and_at_the_end():
    schedule = Schedule.of(train_settings(iterations=4100))
    cast = [i for i in range(1, 4101) if schedule.casts_shadows(i)]
    assert cast == [410, 1025, 1640, 2255, 2870, 3485, 4100]
    late = Schedule.of(train_settings(iterations=30))
    assert late.casts_shadows(30)


def test_resets_can_be_switched_off():
    schedule = Schedule.of(train_settings(density={"reset_interval": None}))
    assert not any(schedule.resets_opacity(i) or schedule.prunes_huge(i) for i in range(1, 40001))


def test_position_rate_is_log_linear():
    schedule = Schedule.of(train_settings())
    middle = schedule.position_rate(15000, 1.6e-4, 1.6e-6)
    assert middle == pytest.approx(1.6e-5, rel=1e-9)
    assert schedule.position_rate(40000, 1.6e-4, 1.6e-6) == pytest.approx(1.6e-6, rel=1e-9)


def test_other_rates_stay_until_they_fall_log_linearly():
    schedule = Schedule.of(train_settings(iterations=4000, rates={"late_from": 20000}))
    assert [schedule.late_share(i, 0.01) for i in (1, 2000)] == [1.0, 1.0]
    assert schedule.late_share(3000, 0.01) == pytest.approx(0.1, rel=1e-9)
    assert schedule.late_share(4000, 0.01) == pytest.approx(0.01, rel=1e-9)


def test_light_is_renewed_from_the_first_shadows_on():
    schedule = Schedule.of(train_settings(iterations=4000))
    assert [i for i in range(1, 701) if schedule.renews_light(i)] == [400, 500, 600, 700]
