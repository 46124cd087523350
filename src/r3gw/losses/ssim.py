"""Masked SSIM as one fused C++ kernel; `r3gw.losses.ssim_reference` says what it computes."""

from typing import Any

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.autograd.function import once_differentiable

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.


class _MeanSsim(torch.autograd.Function):
    """The kernel makes value and gradient in one sweep, so backward only scales."""

    @staticmethod
    def forward(ctx: Any, rendered: Tensor, target: Tensor, is_valid: Tensor) -> Tensor:
        value: Tensor
        value, gradient = torch.ops.r3gw.mean_ssim(
            rendered, target, is_valid, ctx.needs_input_grad[0]
        )
        ctx.save_for_backward(gradient)
        return value

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor | None, None, None]:
        (gradient,) = ctx.saved_tensors
        return (grad * gradient if ctx.needs_input_grad[0] else None), None, None


def mean_ssim(
    rendered: Float[Tensor, "h w 3"], target: Float[Tensor, "h w 3"], is_valid: Bool[Tensor, "h w"]
) -> Float[Tensor, ""]:
    """Mean SSIM over valid pixels and channels; 1 if there are none. Float32, on the CPU.

    Raises:
        ValueError: If shapes differ, an image is not float32, or `target` requires a gradient,
            which this function does not have.
    """
    if rendered.shape != target.shape or rendered.shape[:2] != is_valid.shape:
        raise ValueError(
            f"SSIM needs pictures and a mask of one size, got {list(rendered.shape)}, "
            f"{list(target.shape)} and {list(is_valid.shape)}"
        )
    if rendered.dtype != torch.float32 or target.dtype != torch.float32:
        raise ValueError(f"SSIM needs float32 pictures, got {rendered.dtype} and {target.dtype}")
    if target.requires_grad:
        raise ValueError("SSIM has no gradient by its target: detach it")
    value: Tensor = _MeanSsim.apply(  # type: ignore[no-untyped-call]
        rendered.contiguous(), target.contiguous(), is_valid.contiguous()
    )
    return value
