"""The display curve: the only place where linear light becomes display values and back.

Display values are ``clamp(linear, 0, 1)**(1/2.2)`` (the paper's gamma, Sec. 4.2).
"""

import numpy as np
import torch
from jaxtyping import Float
from numpy.typing import NDArray
from torch import Tensor

GAMMA = 2.2
# Inside the power, so that the slope of x**(1/2.2) stays finite at black.
DARKEST = 1e-4


def display_from_linear(linear: Float[Tensor, "*shape"]) -> Float[Tensor, "*shape"]:
    """Map linear light to display values in ``[DARKEST**(1/2.2), 1]``.

    The backward pass lets a gradient through a clamped value only where it leads back into
    range: an overexposed value may still get darker, a black one lighter.
    """
    return torch.pow(two_way_clamp(linear, DARKEST, 1.0), 1.0 / GAMMA)


def two_way_clamp(
    values: Float[Tensor, "*shape"], low: float, high: float
) -> Float[Tensor, "*shape"]:
    """Clamp whose gradient is kept where descent leads back into the range."""
    clamped: Tensor = _TwoWayClamp.apply(values, low, high)  # type: ignore[no-untyped-call]
    return clamped


def linear_from_display(display: Float[Tensor, "*shape"]) -> Float[Tensor, "*shape"]:
    """Invert `display_from_linear` inside its range."""
    return display.clamp(0.0, 1.0) ** GAMMA


def display_array_from_linear(linear: NDArray[np.floating]) -> NDArray[np.float32]:
    """NumPy twin of `display_from_linear` for pictures on disk; black stays 0."""
    display: NDArray[np.float32] = (np.clip(linear, 0.0, 1.0) ** (1.0 / GAMMA)).astype(np.float32)
    return display


class _TwoWayClamp(torch.autograd.Function):
    """See `two_way_clamp`."""

    @staticmethod
    def forward(ctx, value: Tensor, low: float, high: float) -> Tensor:  # type: ignore[no-untyped-def]
        ctx.save_for_backward(value)
        ctx.low, ctx.high = low, high
        return value.clamp(low, high)

    @staticmethod
    def backward(ctx, gradient: Tensor) -> tuple[Tensor, None, None]:  # type: ignore[no-untyped-def]
        (value,) = ctx.saved_tensors
        # Descent moves against the gradient: positive gradients pull the value down.
        stuck = ((value < ctx.low) & (gradient > 0)) | ((value > ctx.high) & (gradient < 0))
        return gradient.masked_fill(stuck, 0.0), None, None
