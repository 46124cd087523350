"""What a model is made of, as buffers of one picture: surfaces, foreground alone, sky alone."""

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.lighting import sh
from r3gw.model.attributes import ALBEDO
from r3gw.model.model import SceneModel
from r3gw.rendering.channels import Layers
from r3gw.rendering.compose import SMALLEST_ALPHA, Sunlight, draw, shaded_splats
from r3gw.rendering.splats import splats_of


@dataclass(frozen=True)
class Surfaces:
    """What a model says about the surfaces of one picture.

    Attributes:
        albedo: ``[H, W, 3]`` linear, of the foreground alone.
        normal: ``[H, W, 3]`` world, unit; 0 where there is no foreground.
        depth: ``[H, W]`` expected camera z of both sets, world units.
        foreground_alpha: ``[H, W]`` opacity that the foreground contributes.
    """

    albedo: Float[np.ndarray, "h w 3"]
    normal: Float[np.ndarray, "h w 3"]
    depth: Float[np.ndarray, "h w"]
    foreground_alpha: Float[np.ndarray, "h w"]


@torch.no_grad()
def surfaces_of(model: SceneModel, camera: Camera) -> Surfaces:
    """Render the model's surfaces; no light takes part."""
    albedo = ALBEDO.of(model.foreground)
    no_light = albedo.new_zeros(sh.num_coefficients(2), 3)
    splats = splats_of(model, camera, no_light, None, Layers.OPACITY)
    nothing = albedo.new_zeros(len(model.sky.rows), 3)
    rendering = draw(splats.with_colours(torch.cat([albedo, nothing])), camera)
    alpha = rendering.foreground_opacity
    return Surfaces(
        _array(rendering.colour / alpha[..., None].clamp_min(SMALLEST_ALPHA)),
        _array(torch.nn.functional.normalize(rendering.normal, dim=-1)),
        _array(rendering.depth),
        _array(alpha),
    )


def _array(picture: Float[Tensor, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """A float64 array of a tensor on any device."""
    array: Float[np.ndarray, "*shape"] = picture.double().cpu().numpy()
    return array


@torch.no_grad()
def foreground_and_sky(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "skycoeff 3"] | None,
    sunlight: Sunlight | None = None,
) -> tuple[Float[np.ndarray, "h w 3"], Float[np.ndarray, "h w 3"]]:
    """The foreground's and the sky's share of a picture, on black; they add up to it.

    Args:
        model: The scene.
        camera: Where from.
        light: SH environment light.
        sky_light: Sky coefficients; None paints the sky white.
        sunlight: The part of the light that is shaded as a sun.
    """
    splats = shaded_splats(model, camera, light, sky_light, sunlight=sunlight)
    colours = splats.colours
    rows = torch.arange(len(colours), device=colours.device)[:, None]
    is_foreground = rows < len(model.foreground)
    shares = []
    for is_shown in (is_foreground, ~is_foreground):
        shown = draw(splats.with_colours(colours * is_shown), camera)
        shares.append(_array(shown.colour))
    return shares[0], shares[1]
