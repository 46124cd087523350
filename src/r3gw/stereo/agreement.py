"""Depths that another photo confirms, and the points that they make together."""

from collections.abc import Sequence

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.stereo.photos import StereoPhoto, lifted, projected
from r3gw.stereo.sweep import DepthMap

TOLERANCE = 0.01  # of a depth
SPACING_PX = 3.0  # of the points that are kept, at the median pixel's size


def confirmed(
    index: int, photos: Sequence[StereoPhoto], maps: Sequence[DepthMap | None]
) -> Bool[Tensor, "h w"]:
    """Where a photo's depth is found in at least one other photo's map too.

    Args:
        index: The photo, whose map is there.
        photos: All photos.
        maps: Their maps; None where a photo has no neighbours.
    """
    own = maps[index]
    assert own is not None  # the caller's choice
    points = lifted(own.depth, own.is_found, photos[index].camera)
    is_confirmed = torch.zeros(len(points), dtype=torch.bool)
    for other, (photo, depths) in enumerate(zip(photos, maps, strict=True)):
        if other == index or depths is None:
            continue
        seen = projected(points, photo.camera)
        inside = seen.is_inside
        row, column = seen.y[inside].long(), seen.x[inside].long()
        off = (depths.depth[row, column] - seen.depth[inside]).abs()
        is_near = off < TOLERANCE * seen.depth[inside]
        is_confirmed[inside] |= depths.is_found[row, column] & is_near
    result = own.is_found.clone()
    result[own.is_found] = is_confirmed
    return result


def thinned(points: Float[Tensor, "n 3"], spacing: float) -> Float[Tensor, "m 3"]:
    """One point, the mean, for each cube of side ``spacing`` (world units) that holds any."""
    cubes = torch.floor(points / spacing).long()
    numbers = torch.unique(cubes, dim=0, return_inverse=True)[1]
    count = int(numbers.max()) + 1 if len(points) else 0
    sums = torch.zeros(count, 3, dtype=points.dtype).index_add_(0, numbers, points)
    counts = torch.bincount(numbers, minlength=count)
    return sums / counts[:, None]
