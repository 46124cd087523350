"""All losses of one rendered picture as one C++ kernel (Eq. 12, 13 and 15).

What it computes is written plainly in `r3gw.training.losses.reconstruction`,
`r3gw.training.losses.geometry` and `r3gw.training.losses.separation`, which it is held against.
"""

from dataclasses import dataclass
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, UInt8
from torch import Tensor

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.
from r3gw.geometry.cameras import Camera
from r3gw.training.losses.known_gradient import KnownLoss


class PictureWeights(NamedTuple):
    """Factors of the four terms; a term of weight 0 is not computed."""

    l1: float
    dissimilarity: float
    normal: float
    separation: float


@dataclass(frozen=True)
class PictureLosses:
    """The weighted sum with its gradient, and its terms before they are weighted.

    Attributes:
        total: The weighted sum, and its gradients by planes and alpha.
        l1: Mean absolute error over valid pixels and channels.
        dissimilarity: 1 - SSIM, the mean over the same.
        normal: Mean of 1 - N_rendered . N_depth over foreground pixels.
        separation: Eq. 15, a mean over valid pixels and channels.
    """

    total: KnownLoss
    l1: float
    dissimilarity: float
    normal: float
    separation: float


def picture_losses(
    planes: Float[Tensor, "9 h w"],
    alpha: Float[Tensor, "h w"],
    target: UInt8[Tensor, "3 h w"],
    is_valid: Bool[Tensor, "h w"],
    is_sky: Bool[Tensor, "h w"],
    camera: Camera,
    weights: PictureWeights,
) -> PictureLosses:
    """Compare a rendered picture with a photo and its masks; float32, on the CPU.

    Args:
        planes: Channels of `r3gw.rendering.compose`, depth not yet divided by alpha.
        alpha: Accumulated opacity of both sets.
        target: The photo, 0 to 255.
        is_valid: False on occluders; what the planes hold there does not matter.
        is_sky: True on sky.
        camera: The camera of the photo.
        weights: Weights of the terms.
    """
    losses, *gradients = torch.ops.r3gw.picture_losses(
        planes.detach(),
        alpha.detach(),
        target,
        is_valid,
        is_sky,
        weights,
        camera.intrinsics,
        camera.cam_from_world,
    )
    value = sum(weight * loss for weight, loss in zip(weights, losses, strict=True))
    return PictureLosses(KnownLoss(value, (planes, alpha), tuple(gradients)), *losses)
