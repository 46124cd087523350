"""The display curve by hand, its inverse, and gradients that never strand a clamped value."""

import numpy as np
import torch

from r3gw.imaging.colour import (
    DARKEST,
    display_array_from_linear,
    display_from_linear,
    linear_from_display,
    two_way_clamp,
)


def test_curve_by_hand():
    linear = torch.tensor([-1.0, 0.0, 0.5, 1.0, 7.0])
    darkest = DARKEST ** (1 / 2.2)
    expected = torch.tensor([darkest, darkest, 0.5 ** (1 / 2.2), 1.0, 1.0])
    torch.testing.assert_close(display_from_linear(linear), expected, rtol=1e-6, atol=0)


def test_inverse():
    linear = torch.linspace(0.001, 1.0, 50)
    again = linear_from_display(display_from_linear(linear))
    torch.testing.assert_close(again, linear, rtol=1e-5, atol=0)


def test_numpy_twin_keeps_black():
    found = display_array_from_linear(np.array([0.0, 0.25, 2.0]))
    np.testing.assert_allclose(found, [0.0, 0.25 ** (1 / 2.2), 1.0], rtol=1e-6, atol=0)


def test_clamp_passes_only_gradients_that_lead_back():
    """Descent moves against the gradient: a value above 1 may only get a positive one."""
    values = torch.tensor([-0.5, -0.5, 0.5, 0.5, 1.5, 1.5], requires_grad=True)
    upstream = torch.tensor([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    torch.autograd.backward(two_way_clamp(values, 0.0, 1.0), upstream)
    expected = torch.tensor([0.0, -1.0, 1.0, -1.0, 1.0, 0.0])
    assert values.grad is not None
    torch.testing.assert_close(values.grad, expected, rtol=0, atol=0)


def test_slope_is_finite_at_black_and_right_inside():
    linear = torch.tensor([0.0, 0.3], requires_grad=True)
    torch.autograd.backward(display_from_linear(linear), torch.tensor([-1.0, 1.0]))
    assert linear.grad is not None
    assert np.isfinite(linear.grad.numpy()).all()
    slope = 0.3 ** (1 / 2.2 - 1) / 2.2
    np.testing.assert_allclose(float(linear.grad[1]), slope, rtol=1e-5, atol=0)
