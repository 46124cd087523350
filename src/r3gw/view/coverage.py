"""Which photos see which points of a scene's surfaces, for the page's line about coverage."""

from collections.abc import Sequence
from typing import Any

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.relight.gaussians import Relightable
from r3gw.relight.visibility import is_seen

MOST_POINTS = 1500
SEED = 0


@torch.no_grad()
def coverage(gaussians: Relightable, cameras: Sequence[Camera]) -> dict[str, Any] | None:
    """Points and the indices of the cameras that see each (web/src/payload.ts, `Coverage`).

    Points are means of foreground Gaussians, drawn with their opacity times area as weight: as
    likely as a pixel is to show them. A camera sees a point if it projects inside the picture and
    is no further away than what the picture shows there.

    Args:
        gaussians: The scene.
        cameras: Cameras of the training photos.

    Returns:
        None if there is no foreground or no camera.
    """
    if not cameras or not gaussians.num_foreground:
        return None
    chosen = _drawn(gaussians)
    points = gaussians.means[chosen]
    seen = torch.stack([is_seen(gaussians, camera, points) for camera in cameras])
    centres = torch.stack([camera.centre for camera in cameras]).to(points)
    return {
        "points": _rounded(points, 4),
        "normals": _rounded(_outer(points, gaussians.normals[chosen], centres, seen), 3),
        "seenBy": [torch.nonzero(column)[:, 0].tolist() for column in seen.T],
    }


def _drawn(gaussians: Relightable) -> Tensor:
    count = gaussians.num_foreground
    longer = gaussians.scales[:count].sort(dim=-1, descending=True).values[:, :2].prod(-1)
    weight = (gaussians.opacities[:count] * longer).double().clamp_min(1e-12)
    generator = torch.Generator().manual_seed(SEED)
    drawn = torch.multinomial(weight, min(MOST_POINTS, count), generator=generator)
    return drawn.sort().values


def _outer(
    points: Float[Tensor, "p 3"],
    normals: Float[Tensor, "p 3"],
    centres: Float[Tensor, "c 3"],
    seen: Bool[Tensor, "c p"],
) -> Float[Tensor, "p 3"]:
    """Normals turned to the side from which most of the cameras that see a point look at it."""
    sides = torch.einsum("cpx,px->cp", centres[:, None] - points, normals).sign()
    is_behind = (sides * seen).sum(0) < 0
    return torch.where(is_behind[:, None], -normals, normals)


def _rounded(values: Float[Tensor, "n c"], digits: int) -> list[list[float]]:
    return [[round(value, digits) for value in row] for row in values.tolist()]
