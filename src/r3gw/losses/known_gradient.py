"""Losses whose kernels make value and gradient in one sweep, as one node of torch's graph."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor
from torch.autograd.function import once_differentiable


@dataclass(frozen=True)
class KnownLoss:
    """A loss with its gradient, both times the loss's weight.

    Attributes:
        value: The weighted loss.
        inputs: What it depends on.
        gradients: Of the weighted loss by each input.
    """

    value: float
    inputs: tuple[Tensor, ...]
    gradients: tuple[Tensor, ...]


class _KnownGradient(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, value: float, gradients: Sequence[Tensor], *inputs: Tensor) -> Tensor:
        ctx.save_for_backward(*gradients)
        return inputs[0].new_tensor(value)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor | None, ...]:
        # A loss that is not multiplied any more has gradient 1: nothing to multiply.
        factor = float(grad)
        scaled = [g if factor == 1.0 else factor * g for g in ctx.saved_tensors]
        return (None, None, *scaled)


def sum_of(losses: Sequence[KnownLoss]) -> Float[Tensor, ""]:
    """The losses' sum as a scalar that carries their gradients."""
    value = sum(loss.value for loss in losses)
    gradients = [gradient for loss in losses for gradient in loss.gradients]
    inputs = [tensor for loss in losses for tensor in loss.inputs]
    total: Tensor = _KnownGradient.apply(  # type: ignore[no-untyped-call]
        value, gradients, *inputs
    )
    return total
