"""Losses times their weights, and their sum: plain tensors and those whose gradient is known."""

from collections.abc import Sequence
from dataclasses import dataclass

from jaxtyping import Float
from torch import Tensor

from r3gw.native import ops


@dataclass(frozen=True)
class KnownLoss:
    """A loss whose kernel made value and gradient in one sweep, both times the loss's weight.

    Attributes:
        value: The weighted loss.
        inputs: What it depends on.
        gradients: Gradient of the weighted loss by each of the inputs.
    """

    value: float
    inputs: tuple[Tensor, ...]
    gradients: tuple[Tensor, ...]


Weighted = Float[Tensor, ""] | KnownLoss


def value_of(loss: Weighted) -> float:
    """The number."""
    return loss.value if isinstance(loss, KnownLoss) else float(loss.detach())


def sum_of(losses: Sequence[Weighted]) -> Float[Tensor, ""]:
    """The losses' sum, at least one, as a scalar that carries their gradients.

    All losses of known gradient become one node of torch's graph.
    """
    known = [loss for loss in losses if isinstance(loss, KnownLoss)]
    plain = [loss for loss in losses if not isinstance(loss, KnownLoss)]
    if known:
        value = sum(loss.value for loss in known)
        gradients = [gradient for loss in known for gradient in loss.gradients]
        inputs = [tensor for loss in known for tensor in loss.inputs]
        plain.insert(0, ops.known_gradient(value, gradients, inputs))
    total, *others = plain
    for loss in others:
        total = total + loss
    return total
