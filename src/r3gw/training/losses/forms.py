"""The two forms in which training computes its losses: plain torch, and fused kernels.

A loss is defined once, in plain torch (`reconstruction`, `geometry`, `separation`, `lighting`).
`plain` puts those of a picture together; `fused` computes the same with kernels and falls back to
`plain` where there are none. The setting ``losses`` chooses between them (`choice`). A loss without
a kernel needs no entry here: the objective adds its weighted tensor to the others.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

from jaxtyping import Bool, Float, UInt8
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.training.losses.weighted import Weighted


class PictureWeights(NamedTuple):
    """Factors of a picture's losses; one of weight 0 is not computed.

    Eq. 15 (`separation`) and the silhouette exclude each other: they read the same channel, drawn
    with other `r3gw.rendering.channels.Layers`.
    """

    l1: float = 0.0
    dissimilarity: float = 0.0
    normal: float = 0.0
    separation: float = 0.0
    silhouette: float = 0.0


@dataclass(frozen=True)
class PictureLosses:
    """The weighted sum of a picture's losses, and each of them before it is weighted.

    Attributes:
        total: Depends on planes and alpha.
        l1: Mean absolute error over valid pixels and channels.
        dissimilarity: 1 - SSIM, the mean over the same.
        normal: Mean of 1 - N_rendered . N_depth over foreground pixels.
        separation: Eq. 15, a mean over valid pixels and channels.
        silhouette: `r3gw.training.losses.separation.silhouette_loss`.
    """

    total: Weighted
    l1: float
    dissimilarity: float
    normal: float
    separation: float
    silhouette: float


class LossForms(Protocol):
    """What `plain` and `fused` offer; every loss comes times its weight."""

    def picture(
        self,
        planes: Float[Tensor, "channels h w"],
        alpha: Float[Tensor, "h w"],
        target: UInt8[Tensor, "3 h w"],
        is_valid: Bool[Tensor, "h w"],
        is_sky: Bool[Tensor, "h w"],
        camera: Camera,
        weights: PictureWeights,
        solid: float,
    ) -> PictureLosses:
        """Compare a rendered picture with a photo and its masks (Eq. 12, 13 and 15).

        Args:
            planes: Channels of `r3gw.rendering.channels`, depth not yet divided by alpha.
            alpha: Accumulated opacity of both sets.
            target: The photo, 0 to 255.
            is_valid: False on occluders; what the planes hold there does not matter.
            is_sky: True on sky.
            camera: The view.
            weights: Factors of the losses.
            solid: Weight, within the silhouette, of what the foreground lets through off the sky.
        """
        ...

    def positivity(
        self, light: Float[Tensor, "coeff 3"], directions: Float[Tensor, "m 3"], weight: float
    ) -> Weighted:
        """`r3gw.training.losses.lighting.positivity_loss` times its weight."""
        ...

    def flatness(
        self, smallest_scales: Float[Tensor, "f"], radii_px: Float[Tensor, "n"], weight: float
    ) -> Weighted:
        """`r3gw.training.losses.geometry.flatness_loss` times its weight.

        Args:
            smallest_scales: The smallest scale of each foreground Gaussian, world units.
            radii_px: Of all Gaussians, foreground first; 0 where not visible.
            weight: Factor of the loss.
        """
        ...

    def sky_depth(
        self,
        depths: Float[Tensor, "n"],
        radii_px: Float[Tensor, "n"],
        num_foreground: int,
        gamma: float,
        weight: float,
    ) -> Weighted:
        """`r3gw.training.losses.separation.sky_depth_loss` times its weight.

        Args:
            depths: Camera z of all Gaussians, foreground first. The foreground gets no gradient.
            radii_px: 0 where a Gaussian is not visible.
            num_foreground: How many of them are foreground.
            gamma: Inverse length, per world unit.
            weight: Factor of the loss.
        """
        ...
