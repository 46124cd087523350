"""What a model is made of, as buffers of one picture: surfaces, foreground alone, sky alone."""

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.gaussians.compose import (
    SMALLEST_ALPHA,
    foreground_colours,
    render_features,
)
from r3gw.gaussians.foreground import directions_to, facing_normals
from r3gw.gaussians.model import SceneModel
from r3gw.geometry.cameras import Camera


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
    rows = model.foreground
    normals = facing_normals(rows, directions_to(rows["means"], camera.centre))
    nothing = torch.zeros(len(model.sky.rows), 3)
    albedo = torch.cat([rows["albedo_logits"].sigmoid(), nothing])
    rendering = render_features(model, camera, albedo, normals)
    presence = torch.cat([torch.ones(len(rows), 3), nothing])
    alpha = render_features(model, camera, presence, normals).colour[..., :1]
    return Surfaces(
        (rendering.colour / alpha.clamp_min(SMALLEST_ALPHA)).double().numpy(),
        torch.nn.functional.normalize(rendering.normal, dim=-1).double().numpy(),
        rendering.depth.double().numpy(),
        alpha[..., 0].double().numpy(),
    )


@torch.no_grad()
def apart(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "skycoeff 3"] | None,
) -> tuple[Float[np.ndarray, "h w 3"], Float[np.ndarray, "h w 3"]]:
    """The foreground's and the sky's share of a picture, on black; they add up to it.

    Args:
        model: The scene.
        camera: Where from.
        light: SH environment light.
        sky_light: Sky coefficients; None paints the sky white.
    """
    foreground, normals = foreground_colours(model, camera, light)
    num_sky = len(model.sky.rows)
    sky = torch.ones(num_sky, 3)
    if sky_light is not None:
        sky = model.sky.colours(sky_light, camera.centre)
    shares = []
    for colours in (
        torch.cat([foreground, torch.zeros(num_sky, 3)]),
        torch.cat([torch.zeros_like(foreground), sky]),
    ):
        shares.append(render_features(model, camera, colours, normals).colour.double().numpy())
    return shares[0], shares[1]
