"""r3gw.lighting.irradiance against numerical integrals of ``L(w) max(0, n.w)`` over the sphere."""

from math import pi

import pytest
import torch

from r3gw.lighting import envmap, sh
from r3gw.lighting.irradiance import DARKEST_IRRADIANCE, irradiance


@pytest.fixture
def normals() -> torch.Tensor:
    """40 unit normals, float32."""
    vectors = torch.randn(40, 3, generator=torch.Generator().manual_seed(0))
    return torch.nn.functional.normalize(vectors, dim=-1)


def integrated(env_map: torch.Tensor, normals: torch.Tensor) -> torch.Tensor:
    """Irradiance by summing over a map's pixels, weighted by their solid angle."""
    height, width = env_map.shape[:2]
    directions = envmap.pixel_directions(height, width).reshape(-1, 3)
    theta = pi * (torch.arange(height, dtype=torch.float64) + 0.5) / height
    solid_angle = torch.sin(theta) * (pi / height) * (2 * pi / width)
    weights = solid_angle.repeat_interleave(width)[:, None] * env_map.reshape(-1, 3).double()
    return ((normals.double() @ directions.T).clamp_min(0) @ weights).float()


def test_uniform_light_gives_pi(normals):
    light = torch.zeros(25, 3)
    light[0] = (4 * pi) ** 0.5 * torch.tensor([0.5, 1.0, 2.0])
    expected = pi * torch.tensor([0.5, 1.0, 2.0]).expand(40, 3)
    torch.testing.assert_close(irradiance(light, normals), expected, rtol=1e-6, atol=0)


def test_exact_for_light_of_degree_2(normals):
    light = 0.1 * torch.randn(9, 3, generator=torch.Generator().manual_seed(1))
    light[0] = 5.0
    expected = integrated(envmap.draw(light, 128), normals)
    torch.testing.assert_close(irradiance(light, normals), expected, rtol=1e-3, atol=0)


def test_bands_above_2_do_not_count(normals):
    light = torch.randn(25, 3, generator=torch.Generator().manual_seed(2)).abs()
    light[0] = 20.0
    torch.testing.assert_close(
        irradiance(light, normals), irradiance(light[:9], normals), rtol=0, atol=0
    )


def test_monte_carlo_over_a_map_with_sun_and_ground(normals):
    directions = envmap.pixel_directions(64, 128)
    sun = torch.nn.functional.normalize(torch.tensor([0.5, -0.7, 0.5]).double(), dim=-1)
    sky = torch.where(directions[..., 1:2] < 0, 1.0, 0.2) * torch.tensor([0.6, 0.8, 1.0])
    env_map = (sky + 30.0 * (directions @ sun > 0.995)[..., None]).float()
    generator = torch.Generator().manual_seed(4)
    samples = torch.randn(400_000, 3, generator=generator, dtype=torch.float64)
    samples = torch.nn.functional.normalize(samples, dim=-1)
    theta, phi = torch.acos(-samples[:, 1]), torch.atan2(samples[:, 0], samples[:, 2])
    row = (theta / pi * 64).long().clamp(0, 63)
    column = ((phi / (2 * pi) + 0.5) * 128).long().clamp(0, 127)
    radiance = env_map[row, column].double()
    cosines = (normals.double() @ samples.T).clamp_min(0)
    expected = (4 * pi / len(samples) * cosines @ radiance).float()
    got = irradiance(envmap.project(env_map, directions, 2), normals)
    # Bands above 2 hold about a percent of the irradiance (Ramamoorthi and Hanrahan 2001).
    assert ((got - expected).abs().mean() / expected.mean()) < 0.03
    assert ((got - expected).abs().max() / expected.mean()) < 0.12


def test_light_of_degree_1_and_0_is_accepted(normals):
    light = torch.tensor([[3.0] * 3, [0.1] * 3, [0.2] * 3, [0.3] * 3])
    expected = sh.radiance(light * torch.tensor([pi] + [2 * pi / 3] * 3)[:, None], normals)
    torch.testing.assert_close(irradiance(light, normals), expected, rtol=1e-6, atol=1e-6)
    assert irradiance(light[:1], normals).shape == (40, 3)


def test_never_below_its_floor(normals):
    light = torch.zeros(9, 3)
    light[0] = -1.0
    assert (irradiance(light, normals) == DARKEST_IRRADIANCE).all()
