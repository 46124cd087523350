"""Light positivity (Eq. 12): learned environment light must not be negative anywhere."""

from math import pi

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.spherical import direction_from_angles
from r3gw.lighting import sh


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
