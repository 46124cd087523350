"""Sky angles: ``d = (sin t sin p, -cos t, sin t cos p)``, t (theta) from up, p (phi) from +z to +x.

The same angles name the directions of our environment maps (docs/conventions.md).
"""

import torch
from jaxtyping import Float
from torch import Tensor


def direction_from_angles(
    theta: Float[Tensor, "*batch"], phi: Float[Tensor, "*batch"]
) -> Float[Tensor, "*batch 3"]:
    """Unit vectors of polar angle ``theta`` (from up = -y) and azimuth ``phi``, in radians."""
    sine = torch.sin(theta)
    return torch.stack([sine * torch.sin(phi), -torch.cos(theta), sine * torch.cos(phi)], dim=-1)


def angles_from_direction(
    directions: Float[Tensor, "*batch 3"],
) -> tuple[Float[Tensor, "*batch"], Float[Tensor, "*batch"]]:
    """Invert `direction_from_angles`: theta in [0, pi], phi in (-pi, pi]; any length > 0."""
    x, y, z = directions.unbind(-1)
    theta = torch.atan2(torch.hypot(x, z), -y)
    return theta, torch.atan2(x, z)
