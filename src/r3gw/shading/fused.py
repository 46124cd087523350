"""Shading as one C++ kernel; `r3gw.shading.cook_torrance.shade` says what it computes."""

from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor
from torch.autograd.function import once_differentiable

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.
from r3gw.shading.brdf_table import brdf_table

COEFFICIENTS = (9, 25)  # SH degree 2 and 4: what the kernel is compiled for.


class _Shade(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any,
        normals: Tensor,
        to_camera: Tensor,
        albedo: Tensor,
        roughness: Tensor,
        light: Tensor,
        table: Tensor | None,
    ) -> Tensor:
        ctx.save_for_backward(normals, to_camera, albedo, roughness, light)
        ctx.table = table
        colours: Tensor = torch.ops.r3gw.shade(normals, to_camera, albedo, roughness, light, table)
        return colours

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor | None, ...]:
        to_normals, to_albedo, to_roughness, to_light = torch.ops.r3gw.shade_backward(
            grad.contiguous(), *ctx.saved_tensors, ctx.table
        )
        return to_normals, None, to_albedo, to_roughness, to_light, None


def shade(
    normals: Float[Tensor, "n 3"],
    to_camera: Float[Tensor, "n 3"],
    albedo: Float[Tensor, "n 3"],
    roughness: Float[Tensor, "n"],
    light: Float[Tensor, "coeff 3"],
    *,
    with_specular: bool,
) -> Float[Tensor, "n 3"]:
    """Linear radiance towards the camera, as `cook_torrance.shade`; float32, on the CPU.

    Gradients go to all inputs but ``to_camera``.

    Raises:
        ValueError: If ``light`` has neither 9 nor 25 coefficients, a tensor is not float32, or
            ``to_camera`` requires a gradient.
    """
    if light.shape[0] not in COEFFICIENTS:
        raise ValueError(f"fused shading needs 9 or 25 light coefficients, got {light.shape[0]}")
    if to_camera.requires_grad:
        raise ValueError("fused shading has no gradient by to_camera: detach it")
    tensors = [normals, to_camera, albedo, roughness, light]
    if any(tensor.dtype != torch.float32 for tensor in tensors):
        raise ValueError(f"fused shading needs float32, got {[t.dtype for t in tensors]}")
    table = brdf_table() if with_specular else None
    colours: Tensor = _Shade.apply(  # type: ignore[no-untyped-call]
        *(tensor.contiguous() for tensor in tensors), table
    )
    return colours
