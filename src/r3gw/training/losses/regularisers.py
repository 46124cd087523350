"""Losses of the light and of the Gaussians themselves as C++ kernels (Eq. 12, 14 and 16).

Each takes its weight and returns the weighted loss. Their plain forms are
`r3gw.training.losses.lighting.positivity_loss`, `r3gw.training.losses.geometry.scale_loss` and
`r3gw.training.losses.separation.sky_depth_loss`.
"""

import torch
from jaxtyping import Float
from torch import Tensor

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.
from r3gw.training.losses.known_gradient import KnownLoss


def positivity_loss(
    light: Float[Tensor, "coeff 3"], directions: Float[Tensor, "m 3"], weight: float
) -> KnownLoss:
    """Mean over directions of the squared norm of ``min(0, L)``; degree 2 or 4."""
    value, gradient = torch.ops.r3gw.positivity(light.detach().contiguous(), directions, weight)
    return KnownLoss(weight * value, (light,), (gradient,))


def flatness_loss(
    smallest_scales: Float[Tensor, "f"], radii_px: Float[Tensor, "n"], weight: float
) -> KnownLoss:
    """Mean smallest scale of the visible foreground, world units; 0 if nothing is visible.

    Args:
        smallest_scales: Smallest scale of each foreground Gaussian, world units.
        radii_px: Radii of all Gaussians, foreground first; 0 where one is not visible.
        weight: Weight of the loss.
    """
    value, gradient = torch.ops.r3gw.flatness(smallest_scales.detach(), radii_px, weight)
    return KnownLoss(weight * value, (smallest_scales,), (gradient,))


def sky_depth_loss(
    depths: Float[Tensor, "n"],
    radii_px: Float[Tensor, "n"],
    num_foreground: int,
    gamma: float,
    weight: float,
) -> KnownLoss:
    """``exp(-gamma (mean sky depth - mean foreground depth))``; 0 where a set is not visible.

    Args:
        depths: Camera z of all Gaussians, foreground first. The foreground gets no gradient.
        radii_px: 0 where a Gaussian is not visible.
        num_foreground: How many of them are foreground.
        gamma: How fast the loss falls with the distance, per world unit.
        weight: Weight of the loss.
    """
    value, gradient = torch.ops.r3gw.sky_depth(
        depths.detach(), radii_px, num_foreground, gamma, weight
    )
    return KnownLoss(weight * value, (depths,), (gradient,))
