"""Kernels of the light's and the Gaussians' losses against their plain forms in float64."""

import pytest
import torch

from r3gw.losses import geometry, lighting, regularisers, separation


def check(found, leaf, expected, exact):
    """Values and gradients agree."""
    torch.testing.assert_close(found.double(), expected, rtol=1e-5, atol=1e-7)
    (2 * found).backward()
    (2 * expected).backward()
    largest = float(exact.grad.abs().max())
    torch.testing.assert_close(leaf.grad.double(), exact.grad, rtol=1e-4, atol=1e-5 * largest)


@pytest.mark.parametrize("coefficients", [9, 25])
@pytest.mark.parametrize("count", [1, 16, 100, 256])
def test_positivity(coefficients, count):
    generator = torch.Generator().manual_seed(count)
    light = torch.randn(coefficients, 3, generator=generator)
    directions = lighting.random_directions(count, "sphere", generator)
    leaf, exact = light.clone().requires_grad_(), light.double().requires_grad_()
    found = regularisers.positivity_loss(leaf, directions)
    check(found, leaf, lighting.positivity_loss(exact, directions.double()), exact)


def test_positivity_of_a_light_that_is_not_a_number():
    light = torch.full((9, 3), torch.nan)
    directions = torch.tensor([[0.0, -1.0, 0.0]])
    assert torch.isnan(regularisers.positivity_loss(light, directions))


def test_flatness():
    generator = torch.Generator().manual_seed(0)
    log_scales = torch.randn(50, 3, generator=generator)
    radii_px = torch.relu(torch.randn(70, generator=generator))
    leaf = log_scales.clone().requires_grad_()
    exact = log_scales.double().requires_grad_()
    found = regularisers.flatness_loss(leaf.exp().amin(dim=-1), radii_px)
    check(found, leaf, geometry.scale_loss(exact, radii_px[:50] > 0), exact)


def test_flatness_of_nothing_visible():
    assert float(regularisers.flatness_loss(torch.ones(4), torch.zeros(9))) == 0.0


def test_sky_depth():
    generator = torch.Generator().manual_seed(0)
    depths = 5 + 40 * torch.rand(70, generator=generator)
    radii_px = torch.relu(torch.randn(70, generator=generator))
    leaf, exact = depths.clone().requires_grad_(), depths.double().requires_grad_()
    found = regularisers.sky_depth_loss(leaf, radii_px, 50, gamma=0.02)
    check(found, leaf, separation.sky_depth_loss(exact, radii_px > 0, 50, 0.02), exact)
    assert not leaf.grad[:50].any()


@pytest.mark.parametrize("hidden", [slice(0, 50), slice(50, 70)])
def test_sky_depth_without_one_of_the_sets(hidden):
    radii_px = torch.ones(70)
    radii_px[hidden] = 0.0
    depths = torch.rand(70, requires_grad=True)
    found = regularisers.sky_depth_loss(depths, radii_px, 50, gamma=0.02)
    found.backward()
    assert found.item() == 0.0
    assert not depths.grad.any()
