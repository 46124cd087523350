"""Losses on a learned light: nowhere negative (Eq. 12); its sky looks as in the photo."""

import torch
from jaxtyping import Bool, Float
from torch import Tensor

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.
from r3gw.lighting import sh


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


def visible_sky_loss(
    open_sky: Float[Tensor, "coeff 3"],
    directions: Float[Tensor, "k 3"],
    radiance: Float[Tensor, "k 3"],
    is_clipped: Bool[Tensor, "k 3"],
) -> Float[Tensor, ""]:
    """Mean squared distance of a learned sky from what the photo shows of it (beyond the paper).

    Args:
        open_sky: SH radiance above the horizon.
        directions: Unit vectors.
        radiance: Linear, as the photo shows it.
        is_clipped: Where ``radiance`` is a lower bound: only a darker sky counts.
    """
    missing = radiance - sh.radiance(open_sky, directions)
    missing = torch.where(is_clipped, missing.clamp_min(0.0), missing)
    return missing.square().sum(-1).mean()
