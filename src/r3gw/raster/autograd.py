"""Glue between torch's autograd and the C++ kernels: projection and compositing.

Two functions rather than one, so that the projected means are a tensor of the graph in between
and collect their own gradient, as densification needs.
"""

from dataclasses import dataclass
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor
from torch.autograd.function import once_differentiable

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.


@dataclass(frozen=True)
class View:
    """A camera and its image: pose, (fx, fy, cx, cy) in pixels, size in pixels."""

    cam_from_world: Float[Tensor, "rows 4"]
    intrinsics: list[float]
    width: int
    height: int


class Project(torch.autograd.Function):
    """EWA projection; see csrc/projection.h for the four tensors that it returns."""

    @staticmethod
    def forward(
        ctx: Any,
        means: Tensor,
        quaternions: Tensor,
        scales: Tensor,
        opacities: Tensor,
        view: View,
    ) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return means2d, factors (differentiable), screen and radii (not)."""
        camera = (view.cam_from_world, view.intrinsics, view.width, view.height)
        means2d, factors, screen, radii = torch.ops.r3gw.project(
            means, quaternions, scales, opacities, *camera
        )
        ctx.camera = camera
        ctx.save_for_backward(means, quaternions, scales, radii)
        ctx.mark_non_differentiable(screen, radii)
        return means2d, factors, screen, radii

    @staticmethod
    @once_differentiable
    def backward(
        ctx: Any, grad_means2d: Tensor, grad_factors: Tensor, *_: Tensor
    ) -> tuple[Tensor | None, ...]:
        """Gradients of means, quaternions and scales; opacities only cull here."""
        gradients = torch.ops.r3gw.project_backward(
            grad_means2d.contiguous(), grad_factors.contiguous(), *ctx.saved_tensors, *ctx.camera
        )
        return (*gradients, None, None)


class Composite(torch.autograd.Function):
    """Tiling, sorting and front-to-back compositing of projected Gaussians."""

    @staticmethod
    def forward(
        ctx: Any,
        means2d: Tensor,
        factors: Tensor,
        opacities: Tensor,
        features: Tensor,
        background: Tensor | None,
        screen: Tensor,
        radii: Tensor,
        size: tuple[int, int],
        num_feature_gradients: int,
    ) -> tuple[Tensor, Tensor]:
        """Return the planes [C, H, W] and their alpha [H, W]; `size` is (width, height)."""
        planes, alpha, ctx.frame = torch.ops.r3gw.composite(
            means2d, factors, screen, radii, features, background, *size
        )
        ctx.num_feature_gradients = num_feature_gradients
        ctx.set_materialize_grads(False)
        ctx.save_for_backward(planes, alpha, means2d, factors, screen, opacities, features)
        return planes, alpha

    @staticmethod
    @once_differentiable
    def backward(
        ctx: Any, grad_planes: Tensor | None, grad_alpha: Tensor | None
    ) -> tuple[Tensor | None, ...]:
        """Gradients of means2d, factors, opacities, features and background."""
        planes, alpha, means2d, factors, screen, opacities, features = ctx.saved_tensors
        grad_planes = torch.zeros_like(planes) if grad_planes is None else grad_planes.contiguous()
        grad_alpha = None if grad_alpha is None else grad_alpha.contiguous()
        columns = ctx.num_feature_gradients if ctx.needs_input_grad[3] else 0
        to_means2d, to_factors, to_opacities, to_features = torch.ops.r3gw.composite_backward(
            ctx.frame,
            grad_planes,
            grad_alpha,
            *(planes, alpha, means2d, factors, screen, opacities, features),
            columns,
        )
        to_background = None
        if ctx.needs_input_grad[4]:
            to_background = torch.ops.r3gw.background_gradient(grad_planes, alpha)
        return to_means2d, to_factors, to_opacities, to_features, to_background, *[None] * 4
