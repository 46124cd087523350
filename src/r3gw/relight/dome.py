"""Where the sky's Gaussians hang: the sphere through them, and where rays leave it."""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

FEWEST_POINTS = 16
LARGEST_DEVIATION = 0.02  # of the points from the sphere, RMS, in radii


@dataclass(frozen=True)
class Dome:
    """A sphere in the world."""

    centre: Float[Tensor, "3"]
    radius: float

    def exits(
        self, origin: Float[Tensor, "3"], directions: Float[Tensor, "*batch 3"]
    ) -> Float[Tensor, "*batch 3"] | None:
        """Points at which rays from inside leave the sphere; None if they begin outside.

        Args:
            origin: Where all rays begin, in the world.
            directions: Unit directions.
        """
        start = origin.to(directions) - self.centre.to(directions)
        inside = self.radius**2 - (start**2).sum()
        if inside <= 0:
            return None
        along = directions @ start
        distance = (along**2 + inside).sqrt() - along
        return origin.to(directions) + distance[..., None] * directions


def dome_through(points: Float[Tensor, "n 3"]) -> Dome | None:
    """The sphere through points, in least squares; None if there are few or they lie on none."""
    if len(points) < FEWEST_POINTS:
        return None
    exact = points.double()
    middle = exact.mean(dim=0)
    local = exact - middle
    # |p - c|^2 = r^2 is linear in c and r^2 - |c|^2.
    left = torch.cat([2 * local, torch.ones(len(local), 1, dtype=torch.float64)], dim=-1)
    solution = torch.linalg.lstsq(left, (local**2).sum(-1, keepdim=True)).solution[:, 0]
    radius_squared = solution[3] + (solution[:3] ** 2).sum()
    if not torch.isfinite(solution).all() or radius_squared <= 0:
        return None
    # Float32, because the last bits of the solution depend on where the points lie in memory.
    radius = float(radius_squared.sqrt().float())
    off = (local - solution[:3]).norm(dim=-1) - radius
    if float((off**2).mean().sqrt()) > LARGEST_DEVIATION * radius:
        return None
    return Dome((middle + solution[:3]).float(), radius)
