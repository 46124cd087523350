"""Kernels of the light's and the Gaussians' losses against their plain forms in float64."""

from math import isnan

import pytest
import torch

from r3gw.training.losses import fused, lighting, plain
from r3gw.training.losses.weighted import KnownLoss, sum_of, value_of

WEIGHT = 0.7


def check(known, leaf, expected, exact):
    """Weighted values and gradients agree."""
    assert isinstance(known, KnownLoss)
    found = sum_of([known])
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
    found = fused.positivity(leaf, directions, WEIGHT)
    check(found, leaf, plain.positivity(exact, directions.double(), WEIGHT), exact)


def test_positivity_of_a_light_that_is_not_a_number():
    light = torch.full((9, 3), torch.nan)
    directions = torch.tensor([[0.0, -1.0, 0.0]])
    assert isnan(value_of(fused.positivity(light, directions, WEIGHT)))


@pytest.mark.parametrize("count", [1, 50, 5000])
def test_flatness(count):
    generator = torch.Generator().manual_seed(0)
    log_scales = torch.randn(count, 3, generator=generator)
    radii_px = torch.relu(torch.randn(count + 20, generator=generator))
    leaf = log_scales.clone().requires_grad_()
    exact = log_scales.double().requires_grad_()
    found = fused.flatness(leaf.exp().amin(dim=-1), radii_px, WEIGHT)
    check(found, leaf, plain.flatness(exact.exp().amin(dim=-1), radii_px.double(), WEIGHT), exact)


def test_flatness_of_nothing_visible():
    assert value_of(fused.flatness(torch.ones(4), torch.zeros(9), WEIGHT)) == 0.0


@pytest.mark.parametrize("front", [1, 50, 5000])
def test_sky_depth(front):
    generator = torch.Generator().manual_seed(0)
    depths = 5 + 40 * torch.rand(front + 20, generator=generator)
    radii_px = torch.relu(torch.randn(front + 20, generator=generator))
    radii_px[0] = 1.0
    leaf, exact = depths.clone().requires_grad_(), depths.double().requires_grad_()
    found = fused.sky_depth(leaf, radii_px, front, 0.02, WEIGHT)
    check(found, leaf, plain.sky_depth(exact, radii_px.double(), front, 0.02, WEIGHT), exact)
    assert not leaf.grad[:front].any()


@pytest.mark.parametrize("hidden", [slice(0, 50), slice(50, 70)])
def test_sky_depth_without_one_of_the_sets(hidden):
    radii_px = torch.ones(70)
    radii_px[hidden] = 0.0
    depths = torch.rand(70, requires_grad=True)
    found = fused.sky_depth(depths, radii_px, 50, 0.02, WEIGHT)
    sum_of([found]).backward()
    assert value_of(found) == 0.0
    assert not depths.grad.any()


def test_losses_add_up():
    """Each input gets its own gradient, one that two losses share gets both."""
    one, other = torch.tensor([1.0, 2.0]), torch.tensor([3.0])
    one.requires_grad_()
    other.requires_grad_()
    losses = [
        KnownLoss(0.5, (one, other), (torch.tensor([1.0, -1.0]), torch.tensor([4.0]))),
        KnownLoss(0.25, (one,), (torch.tensor([10.0, 20.0]),)),
    ]
    total = sum_of(losses)
    assert total.item() == 0.75
    total.backward()
    assert one.grad.tolist() == [11.0, 19.0]
    assert other.grad.tolist() == [4.0]


def test_known_and_plain_losses_add_up():
    """A loss that has no kernel joins those that have one."""
    value = torch.tensor([1.0, 2.0], requires_grad=True)
    known = KnownLoss(0.5, (value,), (torch.tensor([1.0, -1.0]),))
    total = sum_of([known, value.square().sum(), 2 * value.sum()])
    assert total.item() == pytest.approx(0.5 + 5 + 6, rel=1e-6)
    total.backward()
    assert value.grad.tolist() == [1 + 2 + 2, -1 + 4 + 2]


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_a_degree_or_dtype_without_a_kernel_takes_the_plain_form(dtype):
    generator = torch.Generator().manual_seed(0)
    count = 16 if dtype == torch.float32 else 25
    light = torch.randn(count, 3, generator=generator, dtype=dtype)
    directions = lighting.random_directions(50, "sphere", generator).to(dtype)
    found = fused.positivity(light, directions, WEIGHT)
    assert isinstance(found, torch.Tensor)
    expected = WEIGHT * lighting.positivity_loss(light, directions)
    torch.testing.assert_close(found, expected, rtol=1e-6, atol=0)
