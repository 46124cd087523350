"""Depth of one photo by plane sweep (Collins 1996), compared by normalised cross-correlation.

Photos of tourists differ in exposure, colour and light; correlation of windows without their mean
and contrast does not mind. What is seen in one photo alone has no match, so every depth must win
clearly, in a region of its own, and be confirmed by another photo (`r3gw.stereo.agreement`).
"""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from r3gw.geometry.cameras import pixel_rays
from r3gw.stereo.photos import StereoPhoto

PLANES = 160
DEPTH_MARGINS = (0.7, 1.4)  # on the nearest and the farthest sparse point
DEPTH_QUANTILES = (0.01, 0.99)
WINDOW_PX = 9
BEST_PHOTOS = 2  # that a match is averaged over: what hides a place in one photo hides no match
LEAST_CORRELATION = 0.7
LEAST_LEAD = 0.03  # of the best depth over all that are not next to it
NEXT_PLANES = 4
LEAST_CONTRAST = 3 / 255  # standard deviation in a window
LEAST_REGION_PX = 30
SAME_REGION_PLANES = 2
_SUBPLANES = 16


class DepthMap(NamedTuple):
    """What was found in one photo.

    Attributes:
        depth: Camera z, world units.
        is_found: Where it is to be trusted.
    """

    depth: Float[Tensor, "h w"]
    is_found: Bool[Tensor, "h w"]


def swept_depth(photo: StereoPhoto, others: Sequence[StereoPhoto]) -> DepthMap:
    """Depth at which the other photos look most like this one.

    Args:
        photo: Holds at least one of the sparse points.
        others: Its neighbours, one or more.
    """
    low, high = torch.quantile(photo.known_depths, torch.tensor(DEPTH_QUANTILES).double()).tolist()
    inverse = torch.linspace(1 / (DEPTH_MARGINS[0] * low), 1 / (DEPTH_MARGINS[1] * high), PLANES)
    window = _Windows(photo.grey)
    warps = [_Warp(photo, other) for other in others]
    agreement = torch.stack(
        [
            _best_mean([warp.correlation(window, float(plane)) for warp in warps])
            for plane in inverse
        ]
    )
    best, chosen = agreement.max(dim=0)
    plane = chosen + _between_planes(agreement, chosen)
    is_found = (
        photo.is_matched
        & (best > LEAST_CORRELATION)
        & (best - _runner_up(agreement, chosen) > LEAST_LEAD)
        & (window.deviation > LEAST_CONTRAST)
        & (chosen > 0)
        & (chosen < PLANES - 1)
    )
    step = float(inverse[1] - inverse[0])
    return DepthMap(1 / (inverse[0] + plane * step), _without_specks(plane, is_found))


class _Windows:
    """Means and deviations of a picture's windows."""

    def __init__(self, grey: Float[Tensor, "h w"]) -> None:
        self.grey = grey
        self.mean = _averaged(grey)
        self.deviation = (_averaged(grey.square()) - self.mean.square()).clamp_min(0.0).sqrt()

    def correlation(self, other: "_Windows") -> Float[Tensor, "h w"]:
        """Of each window with the other's in the same place, -1 to 1."""
        shared = _averaged(self.grey * other.grey) - self.mean * other.mean
        return shared / (self.deviation * other.deviation).clamp_min(1e-4)


class _Warp:
    """Brings one photo to where another would see it if all lay in one depth."""

    def __init__(self, photo: StereoPhoto, other: StereoPhoto) -> None:
        fx, fy, cx, cy = other.camera.intrinsics
        matrix = torch.tensor([[fx, 0, cx], [0, fy, cy], [0, 0, 1]], dtype=torch.float64)
        relative = other.camera.cam_from_world @ torch.linalg.inv(photo.camera.cam_from_world)
        self.other = other
        self.rays = pixel_rays(photo.camera) @ (matrix @ relative[:3, :3]).float().T
        self.shift = (matrix @ relative[:3, 3]).float()

    def correlation(self, window: _Windows, inverse_depth: float) -> Float[Tensor, "h w"]:
        """Correlation at one inverse depth; -1 where the other photo does not see it."""
        places = self.rays + self.shift * inverse_depth
        depth = places[..., 2]
        x, y = places[..., 0] / depth, places[..., 1] / depth
        height, width = self.other.grey.shape
        is_seen = (depth > 0) & (x >= 0) & (y >= 0) & (x < width) & (y < height)
        warped = cv2.remap(
            self.other.grey.numpy(),
            (x - 0.5).numpy(),
            (y - 0.5).numpy(),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        found = window.correlation(_Windows(torch.from_numpy(warped)))
        return torch.where(is_seen, found, -1.0)


def _averaged(values: Float[Tensor, "h w"]) -> Float[Tensor, "h w"]:
    size = (WINDOW_PX, WINDOW_PX)
    return torch.from_numpy(cv2.blur(values.numpy(), size, borderType=cv2.BORDER_REFLECT))


def _best_mean(found: Sequence[Float[Tensor, "h w"]]) -> Float[Tensor, "h w"]:
    """Mean over the photos that agree best."""
    return torch.stack(list(found)).topk(min(BEST_PHOTOS, len(found)), dim=0).values.mean(dim=0)


def _between_planes(
    agreement: Float[Tensor, "planes h w"], chosen: Int[Tensor, "h w"]
) -> Float[Tensor, "h w"]:
    """Where a parabola through the best plane and its neighbours is highest, -0.5 to 0.5."""
    before = agreement.gather(0, (chosen - 1).clamp_min(0)[None])[0]
    after = agreement.gather(0, (chosen + 1).clamp_max(PLANES - 1)[None])[0]
    best = agreement.gather(0, chosen[None])[0]
    bend = (before - 2 * best + after).clamp_max(-1e-6)
    return (0.5 * (before - after) / bend).clamp(-0.5, 0.5)


def _runner_up(
    agreement: Float[Tensor, "planes h w"], chosen: Int[Tensor, "h w"]
) -> Float[Tensor, "h w"]:
    """Best agreement of a plane that is not next to the chosen one."""
    second = torch.full_like(agreement[0], -1.0)
    for plane, values in enumerate(agreement):
        is_other = (chosen - plane).abs() > NEXT_PLANES
        second = torch.where(is_other, torch.maximum(second, values), second)
    return second


def _without_specks(
    plane: Float[Tensor, "h w"], is_found: Bool[Tensor, "h w"]
) -> Bool[Tensor, "h w"]:
    """Take away regions of one depth that are smaller than a thing that is seen."""
    steps = torch.where(is_found, plane * _SUBPLANES, -float(_SUBPLANES)).numpy().astype(np.int16)
    cv2.filterSpeckles(steps, -_SUBPLANES, LEAST_REGION_PX, SAME_REGION_PLANES * _SUBPLANES)
    return torch.from_numpy(steps >= 0)
