"""Losses on a learned light: nowhere negative (Eq. 12); its sky looks as in the photo."""

from math import pi

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.geometry.spherical import direction_from_angles
from r3gw.lighting import sh

DARKEST_MEAN = 1e-3  # of a light, as its coefficient of band 0, whose logarithm is taken


def random_directions(
    count: int, domain: str, generator: torch.Generator
) -> Float[Tensor, "{count} 3"]:
    """Unit vectors, uniform on the upper ``hemisphere`` (up = -y) or the whole ``sphere``."""
    height, turn = torch.rand(2, count, generator=generator)
    if domain == "sphere":
        height = 2 * height - 1
    return direction_from_angles(torch.acos(height), 2 * pi * turn)


def positivity_loss(
    light: Float[Tensor, "coeff 3"], directions: Float[Tensor, "m 3"]
) -> Float[Tensor, ""]:
    """Mean over directions of the squared norm of ``min(0, L)``."""
    negative = sh.radiance(light, directions).clamp_max(0.0)
    return negative.square().sum(-1).mean()


def visible_sky_loss(
    open_sky: Float[Tensor, "coeff 3"],
    basis: Float[Tensor, "k coeff"],
    radiance: Float[Tensor, "k 3"],
    is_clipped: Bool[Tensor, "k 3"],
) -> Float[Tensor, ""]:
    """Mean squared distance of a learned sky from what the photo shows of it (beyond the paper).

    Args:
        open_sky: SH radiance above the horizon.
        basis: SH basis in the directions of the photo's sky pixels.
        radiance: Linear, as the photo shows it.
        is_clipped: Where ``radiance`` is a lower bound: only a darker sky counts.
    """
    missing = radiance - basis @ open_sky
    missing = torch.where(is_clipped, missing.clamp_min(0.0), missing)
    return missing.square().sum(-1).mean()


def unlikeness(
    first: Float[Tensor, "coeff 3"], second: Float[Tensor, "coeff 3"], warmth: float
) -> Float[Tensor, ""]:
    """Squared difference of the logarithms of two lights' mean radiances.

    The sum over channels, but that of red against blue counts ``warmth`` times: daylight is warmer
    or colder by the hour and the weather, and hardly ever greener or pinker.
    """
    means = [light[0].clamp_min(DARKEST_MEAN).log() for light in (first, second)]
    return but_warmth(means[0] - means[1], warmth**0.5).square().sum()


def but_warmth(logarithms: Float[Tensor, "*batch 3"], share: float) -> Float[Tensor, "*batch 3"]:
    """Logarithms of colours of whose red against blue a share is left."""
    half = 0.5 * (1 - share) * (logarithms[..., 0] - logarithms[..., 2])
    return torch.stack(
        [logarithms[..., 0] - half, logarithms[..., 1], logarithms[..., 2] + half], dim=-1
    )
