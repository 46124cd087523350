"""Predictions agree with the run that they are made from, and grow with what costs."""

import pytest

from r3gw.pipeline.doctor.cost import MEASURED, predicted_cost, spoken_time


def test_the_measured_run_is_predicted():
    pixels = 240 * 180
    cost = predicted_cost(1000, 15_000, 15_000, float(pixels), 20 * pixels)
    assert cost.seconds == pytest.approx(MEASURED.ms_per_iteration, rel=1e-9, abs=0)


def test_cost_above_the_fixed_part_is_proportional():
    fixed_s = MEASURED.fixed_share * MEASURED.ms_per_iteration  # of 1000 iterations
    one = predicted_cost(1000, 10_000, 15_000, 43_200.0, 1_000_000)
    two = predicted_cost(1000, 20_000, 30_000, 86_400.0, 2_000_000)
    assert two.seconds - fixed_s == pytest.approx(2 * (one.seconds - fixed_s), rel=1e-9, abs=0)
    grown = two.memory_mb - MEASURED.base_mb
    assert grown == pytest.approx(2 * (one.memory_mb - MEASURED.base_mb), rel=1e-9, abs=0)
    longer = predicted_cost(3000, 10_000, 15_000, 43_200.0, 1_000_000)
    assert longer.seconds == pytest.approx(3 * one.seconds, rel=1e-9, abs=0)
    assert longer.memory_mb == one.memory_mb


@pytest.mark.parametrize(
    ("seconds", "said"), [(42, "42 s"), (600, "10 min"), (10_000, "2.8 h"), (400_000, "4.6 days")]
)
def test_spoken_time(seconds, said):
    assert spoken_time(float(seconds)) == said
