"""Losses on a learned light: nowhere negative (Eq. 12); from below comes what the ground sends."""

from math import pi

import torch
from jaxtyping import Float
from torch import Tensor

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.
from r3gw.lighting import sh
from r3gw.lighting.irradiance import irradiance


def random_directions(
    count: int, domain: str, generator: torch.Generator
) -> Float[Tensor, "{count} 3"]:
    """Unit vectors, uniform on the upper ``hemisphere`` (up = -y) or the whole ``sphere``."""
    draws = torch.rand(2, count, generator=generator)
    if domain == "sphere":
        draws[0].mul_(2).sub_(1)
    directions: Tensor = torch.ops.r3gw.directions(draws)
    return directions


def positivity_loss(
    light: Float[Tensor, "coeff 3"], directions: Float[Tensor, "m 3"]
) -> Float[Tensor, ""]:
    """Mean over directions of the squared norm of ``min(0, L)``."""
    negative = sh.radiance(light, directions).clamp_max(0.0)
    return negative.square().sum(-1).mean()


def ground_loss(
    light: Float[Tensor, "coeff 3"], directions: Float[Tensor, "m 3"], reflectance: float
) -> Float[Tensor, ""]:
    """Squared distance of the light from below to that of level ground (beyond the paper).

    Level, matt ground of irradiance E sends ``reflectance / pi * E`` everywhere. Without this,
    photos leave open how much light comes from below, and how much the surfaces reflect.

    Args:
        light: SH coefficients.
        directions: Below the horizon.
        reflectance: Of the ground, 0 to 1.
    """
    up = light.new_tensor([[0.0, -1.0, 0.0]])
    ground = reflectance / pi * irradiance(light, up)
    return (sh.radiance(light, directions) - ground).square().sum(-1).mean()
