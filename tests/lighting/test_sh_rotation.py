"""r3gw.lighting.sh_rotation against turning the map itself, pixel by pixel."""

from math import pi

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from r3gw.geometry.rotations import rotation_about_axis
from r3gw.lighting import envmap, sh
from r3gw.lighting.sh_rotation import rotate


@pytest.fixture
def turn() -> torch.Tensor:
    """Some rotation matrix, from SciPy."""
    return torch.from_numpy(Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix())


def random_map(height: int = 16) -> torch.Tensor:
    """A map of noise, with a few very bright pixels."""
    generator = torch.Generator().manual_seed(3)
    noise = torch.rand(height, 2 * height, 3, generator=generator)
    return noise + 100 * (noise > 0.98)


@pytest.mark.parametrize("degree", [0, 1, 2, 4, 8])
def test_equals_projecting_the_turned_map(turn, degree):
    env_map = random_map()
    directions = envmap.pixel_directions(16, 32)
    expected = envmap.project(env_map, directions @ turn.T, degree)
    got = rotate(envmap.project(env_map, directions, degree), turn)
    torch.testing.assert_close(got, expected, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("columns", [1, 5, 16, -9])
def test_yaw_equals_shifting_the_columns(columns):
    env_map = random_map()
    directions = envmap.pixel_directions(16, 32)
    shifted = torch.roll(env_map, columns, dims=1)
    yaw = rotation_about_axis(1, 2 * pi * columns / 32)
    got = rotate(envmap.project(env_map, directions, 4), yaw)
    torch.testing.assert_close(got, envmap.project(shifted, directions, 4), rtol=1e-5, atol=1e-4)


def test_shines_from_the_turned_direction(turn):
    generator = torch.Generator().manual_seed(1)
    light = torch.randn(25, 3, generator=generator, dtype=torch.float64)
    looks = torch.nn.functional.normalize(
        torch.randn(50, 3, generator=generator, dtype=torch.float64), dim=-1
    )
    turned = sh.radiance(rotate(light, turn), looks @ turn.T)
    torch.testing.assert_close(turned, sh.radiance(light, looks), rtol=0, atol=1e-12)


def test_keeps_the_power_of_every_band_and_undoes_itself(turn):
    light = torch.randn(25, 3, generator=torch.Generator().manual_seed(2), dtype=torch.float64)
    turned = rotate(light, turn)
    for l in range(5):
        band = slice(l * l, (l + 1) ** 2)
        np.testing.assert_allclose(
            turned[band].square().sum(0), light[band].square().sum(0), rtol=1e-12, atol=0
        )
    torch.testing.assert_close(rotate(turned, turn.T), light, rtol=0, atol=1e-12)


def test_a_turned_light_lies_in_memory_as_the_kernels_read_it(turn):
    turned = rotate(torch.rand(25, 3, generator=torch.Generator().manual_seed(0)), turn)
    assert turned.is_contiguous()
