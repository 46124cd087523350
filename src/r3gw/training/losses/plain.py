"""All losses in plain torch, on any device (`r3gw.training.losses.forms`)."""

import torch
from jaxtyping import Bool, Float, UInt8
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.rendering.channels import COLOUR, DEPTH, FOREGROUND, NORMAL, SKY
from r3gw.rendering.compose import SMALLEST_ALPHA
from r3gw.training.losses.forms import PictureLosses, PictureWeights
from r3gw.training.losses.geometry import flatness_loss, normal_loss, normals_from_depth
from r3gw.training.losses.lighting import positivity_loss
from r3gw.training.losses.reconstruction import masked_l1
from r3gw.training.losses.separation import separation_loss, silhouette_loss, sky_depth_loss
from r3gw.training.losses.ssim import mean_ssim


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
    colour = planes[COLOUR].permute(1, 2, 0)
    photo = target.permute(1, 2, 0).to(planes) / 255
    losses = dict.fromkeys(PictureWeights._fields, planes.new_zeros(()))
    if weights.l1 > 0:
        losses["l1"] = masked_l1(colour, photo, is_valid)
    if weights.dissimilarity > 0:
        losses["dissimilarity"] = 1 - mean_ssim(colour, photo, is_valid)
    if weights.normal > 0 and min(alpha.shape) > 1:  # one row of pixels spans no surface
        from_depth = normals_from_depth(planes[DEPTH] / alpha.clamp_min(SMALLEST_ALPHA), camera)
        rendered = planes[NORMAL].permute(1, 2, 0)
        losses["normal"] = normal_loss(rendered, from_depth, is_valid & ~is_sky)
    if weights.separation > 0:
        losses["separation"] = separation_loss(planes[FOREGROUND], planes[SKY], is_sky, is_valid)
    if weights.silhouette > 0:
        losses["silhouette"] = silhouette_loss(planes[FOREGROUND], is_sky, is_valid, solid)
    weighted = [weight * losses[name] for name, weight in weights._asdict().items()]
    values = {name: float(loss.detach()) for name, loss in losses.items()}
    return PictureLosses(total=torch.stack(weighted).sum(), **values)


def positivity(
    light: Float[Tensor, "coeff 3"], directions: Float[Tensor, "m 3"], weight: float
) -> Float[Tensor, ""]:
    """See `r3gw.training.losses.forms.LossForms.positivity`."""
    return weight * positivity_loss(light, directions)


def flatness(
    smallest_scales: Float[Tensor, "f"], radii_px: Float[Tensor, "n"], weight: float
) -> Float[Tensor, ""]:
    """See `r3gw.training.losses.forms.LossForms.flatness`."""
    return weight * flatness_loss(smallest_scales, radii_px[: len(smallest_scales)] > 0)


def sky_depth(
    depths: Float[Tensor, "n"],
    radii_px: Float[Tensor, "n"],
    num_foreground: int,
    gamma: float,
    weight: float,
) -> Float[Tensor, ""]:
    """See `r3gw.training.losses.forms.LossForms.sky_depth`."""
    return weight * sky_depth_loss(depths, radii_px > 0, num_foreground, gamma)
