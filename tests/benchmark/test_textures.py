"""Textures tile without a seam, stay plausible as albedo, and repeat by seed."""

import numpy as np
import pytest

from r3gw.benchmark import textures
from r3gw.benchmark.seeds import stream

MAKERS = {
    "blocks": lambda r: textures.blocks(r, (0.5, 0.4, 0.3), 8, 4, joint=(0.3, 0.3, 0.3)),
    "plaster": lambda r: textures.plaster(r, (0.5, 0.4, 0.3)),
    "speckle": lambda r: textures.speckle(r, (0.1, 0.1, 0.05), (0.3, 0.3, 0.2)),
    "marble": lambda r: textures.marble(r, (0.5, 0.45, 0.4), (0.2, 0.2, 0.2)),
    "planks": lambda r: textures.planks(r, (0.3, 0.2, 0.1)),
}


@pytest.mark.parametrize("name", MAKERS)
def test_albedo_is_plausible_and_repeatable(name: str) -> None:
    first, second, other = (MAKERS[name](stream(seed, name)) for seed in (1, 1, 2))
    assert first.shape == (textures.SIZE, textures.SIZE, 3)
    assert 0.01 <= first.min() < first.max() <= 0.9
    assert first.std() > 0.005
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, other)


@pytest.mark.parametrize("slope", [0.3, 1.0, 1.6])
def test_noise_is_periodic_and_normalised(slope: float) -> None:
    field = textures.noise(stream(0, "noise"), slope)
    assert field.mean() == pytest.approx(0, abs=1e-9)
    assert field.std() == pytest.approx(1, rel=1e-9)
    for axis in (0, 1):
        inside = np.abs(np.diff(field, axis=axis)).mean()
        across = np.abs(field.take(0, axis) - field.take(-1, axis)).mean()
        assert across == pytest.approx(inside, rel=0.25)


def test_a_larger_slope_is_smoother() -> None:
    fields = [textures.noise(stream(0, "n"), slope) for slope in (0.3, 1.0, 2.0)]
    steps = [np.diff(field, axis=0).std() for field in fields]
    assert steps[0] > 1.2 * steps[1] > 1.5 * steps[2]


def test_blocks_have_as_many_joints_as_courses() -> None:
    wall = textures.blocks(
        stream(0, "b"), (0.6, 0.6, 0.6), 8, 4, joint=(0.1, 0.1, 0.1), joint_px=8, variation=0.02
    )
    is_joint = wall.mean(axis=(1, 2)) < 0.35
    assert np.count_nonzero(np.diff(is_joint.astype(int)) == 1) + int(is_joint[0]) == 8
