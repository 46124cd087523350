"""Which photos a photo is compared with."""

from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.stereo.photos import StereoPhoto

MOST_NEIGHBOURS = 5
LEAST_SHARED = 20  # sparse points in both pictures
ANGLE_RANGE_DEG = (0.7, 45.0)  # between two rays to one point
BEST_ANGLES_DEG = (6.0, 20.0)  # from here to there an angle costs nothing


def neighbours(
    index: int, photos: Sequence[StereoPhoto], points: Float[Tensor, "n 3"]
) -> list[int]:
    """Photos that show the same from another place, in about the same size; the best first.

    Args:
        index: The photo in question.
        photos: All photos.
        points: The scene's sparse points, world, float64.
    """
    here = photos[index]
    found = []
    for other, there in enumerate(photos):
        is_shared = here.known.is_inside & there.known.is_inside
        count = int(is_shared.sum())
        if other == index or count < LEAST_SHARED:
            continue
        angle = _middle_angle_deg(here, there, points[is_shared])
        if not ANGLE_RANGE_DEG[0] <= angle <= ANGLE_RANGE_DEG[1]:
            continue
        sizes = [
            photo.camera.intrinsics[0] / float(photo.known.depth[is_shared].median())
            for photo in (here, there)
        ]
        worth = min(angle / BEST_ANGLES_DEG[0], 1.0, BEST_ANGLES_DEG[1] / angle)
        found.append((-count * worth * min(sizes) / max(sizes), other))
    return [other for _, other in sorted(found)[:MOST_NEIGHBOURS]]


def _middle_angle_deg(here: StereoPhoto, there: StereoPhoto, points: Float[Tensor, "k 3"]) -> float:
    """Median angle under which two cameras' rays meet in the points."""
    rays = [
        torch.nn.functional.normalize(photo.camera.centre - points, dim=-1)
        for photo in (here, there)
    ]
    cosine = (rays[0] * rays[1]).sum(-1).clamp(-1.0, 1.0)
    return float(torch.rad2deg(torch.acos(cosine)).median())
