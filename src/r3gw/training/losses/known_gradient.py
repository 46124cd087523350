"""Losses whose kernels make value and gradient in one sweep, as one node of torch's graph."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.


@dataclass(frozen=True)
class KnownLoss:
    """A loss with its gradient, both times the loss's weight.

    Attributes:
        value: The weighted loss.
        inputs: The tensors that the loss depends on.
        gradients: Gradient of the weighted loss by each of the inputs.
    """

    value: float
    inputs: tuple[Tensor, ...]
    gradients: tuple[Tensor, ...]


def sum_of(losses: Sequence[KnownLoss]) -> Float[Tensor, ""]:
    """The losses' sum as a scalar that carries their gradients."""
    value = sum(loss.value for loss in losses)
    gradients = [gradient for loss in losses for gradient in loss.gradients]
    inputs = [tensor for loss in losses for tensor in loss.inputs]
    total: Tensor = torch.ops.r3gw.known_gradient(value, gradients, inputs)
    return total
