"""All losses as C++ kernels that make value and gradient in one sweep.

They compute what `r3gw.training.losses.plain` does, which they are held against and which they fall
back to: for tensors that no kernel takes, and for lights of a degree that none is compiled for.
"""

from jaxtyping import Bool, Float, UInt8
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.native import kernels, ops
from r3gw.rendering.splats import COEFFICIENTS
from r3gw.training.losses import plain
from r3gw.training.losses.forms import PictureLosses, PictureWeights
from r3gw.training.losses.weighted import KnownLoss, Weighted


def picture(
    planes: Float[Tensor, "channels h w"],
    alpha: Float[Tensor, "h w"],
    target: UInt8[Tensor, "3 h w"],
    is_valid: Bool[Tensor, "h w"],
    is_sky: Bool[Tensor, "h w"],
    camera: Camera,
    weights: PictureWeights,
    solid: float,
) -> PictureLosses:
    """See `r3gw.training.losses.forms.LossForms.picture`."""
    if not kernels.take("picture_losses", planes, alpha):
        return plain.picture(planes, alpha, target, is_valid, is_sky, camera, weights, solid)
    losses, *gradients = ops.picture_losses(
        planes.detach(),
        alpha.detach(),
        target,
        is_valid,
        is_sky,
        weights,
        solid,
        camera.intrinsics,
        camera.cam_from_world,
    )
    value = sum(weight * loss for weight, loss in zip(weights, losses, strict=True))
    return PictureLosses(KnownLoss(value, (planes, alpha), tuple(gradients)), *losses)


def positivity(
    light: Float[Tensor, "coeff 3"], directions: Float[Tensor, "m 3"], weight: float
) -> Weighted:
    """See `r3gw.training.losses.forms.LossForms.positivity`."""
    if len(light) not in COEFFICIENTS or not kernels.take("positivity", light, directions):
        return plain.positivity(light, directions, weight)
    value, gradient = ops.positivity(light.detach().contiguous(), directions, weight)
    return KnownLoss(weight * value, (light,), (gradient,))


def flatness(
    smallest_scales: Float[Tensor, "f"], radii_px: Float[Tensor, "n"], weight: float
) -> Weighted:
    """See `r3gw.training.losses.forms.LossForms.flatness`."""
    if not kernels.take("flatness", smallest_scales, radii_px):
        return plain.flatness(smallest_scales, radii_px, weight)
    value, gradient = ops.flatness(smallest_scales.detach(), radii_px, weight)
    return KnownLoss(weight * value, (smallest_scales,), (gradient,))


def sky_depth(
    depths: Float[Tensor, "n"],
    radii_px: Float[Tensor, "n"],
    num_foreground: int,
    gamma: float,
    weight: float,
) -> Weighted:
    """See `r3gw.training.losses.forms.LossForms.sky_depth`."""
    if not kernels.take("sky_depth", depths, radii_px):
        return plain.sky_depth(depths, radii_px, num_foreground, gamma, weight)
    value, gradient = ops.sky_depth(depths.detach(), radii_px, num_foreground, gamma, weight)
    return KnownLoss(weight * value, (depths,), (gradient,))
