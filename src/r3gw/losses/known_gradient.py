"""Losses whose kernels make value and gradient in one sweep, as tensors of torch's graph."""

from collections.abc import Sequence
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor
from torch.autograd.function import once_differentiable


class _KnownGradient(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, value: float, gradients: Sequence[Tensor], *inputs: Tensor) -> Tensor:
        ctx.save_for_backward(*gradients)
        return inputs[0].new_tensor(value)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor | None, ...]:
        # A loss that is a plain term of a sum has gradient 1: nothing to multiply.
        factor = float(grad)
        scaled = [g if factor == 1.0 else factor * g for g in ctx.saved_tensors]
        return (None, None, *scaled)


def known_gradient(
    value: float, gradients: Sequence[Tensor], inputs: Sequence[Tensor]
) -> Float[Tensor, ""]:
    """A scalar ``value`` whose gradient by ``inputs`` is ``gradients``, tensor by tensor."""
    loss: Tensor = _KnownGradient.apply(  # type: ignore[no-untyped-call]
        value, gradients, *inputs
    )
    return loss
