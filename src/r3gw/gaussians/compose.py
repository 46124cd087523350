"""One rendering pass over both sets of Gaussians (method 6).

Feature channels, in this order: display colour (3), camera depth (1), foreground normal (3),
foreground-only and sky-only channel sum (1 each). The last two carry no colour gradient.
"""

from dataclasses import dataclass
from math import pi

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.gaussians.foreground import directions_to, facing_normals
from r3gw.gaussians.model import SceneModel
from r3gw.gaussians.rows import OCCLUSION
from r3gw.geometry.cameras import Camera
from r3gw.imaging.colour import display_from_linear
from r3gw.raster import rasterize
from r3gw.shading.fused import shade

CHANNELS = [3, 1, 3, 1, 1]
NUM_COLOUR_GRADIENTS = 7
SMALLEST_ALPHA = 1e-6


@dataclass(frozen=True)
class Rendering:
    """What one pass returns; N counts foreground Gaussians first, then the sky's.

    Attributes:
        colour: ``[H, W, 3]`` display values on black.
        alpha: ``[H, W]`` accumulated opacity of both sets.
        depth: ``[H, W]`` expected camera z, divided by alpha.
        normal: ``[H, W, 3]`` composited foreground normals, world axes, not normalised.
        foreground, sky: ``[H, W]`` channel sum of each set's colour.
        radii_px: ``[N]``, 0 = not visible.
        means2d: ``[N, 2]`` pixels; its ``.grad`` feeds densification.
        depths: ``[N]`` camera z of every Gaussian.
    """

    colour: Float[Tensor, "h w 3"]
    alpha: Float[Tensor, "h w"]
    depth: Float[Tensor, "h w"]
    normal: Float[Tensor, "h w 3"]
    foreground: Float[Tensor, "h w"]
    sky: Float[Tensor, "h w"]
    radii_px: Float[Tensor, "n"]
    means2d: Float[Tensor, "n 2"]
    depths: Float[Tensor, "n"]


def foreground_colours(
    model: SceneModel, camera: Camera, light: Float[Tensor, "coeff 3"]
) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n 3"]]:
    """Display colours and camera-facing normals of the foreground under ``light``."""
    rows = model.foreground
    to_camera = directions_to(rows["means"], camera.centre).detach()
    normals = facing_normals(rows, to_camera)
    albedo = rows["albedo_logits"].sigmoid()
    linear = shade(
        normals,
        to_camera,
        albedo,
        rows["roughness_logits"].sigmoid(),
        light,
        with_specular=model.settings.model.specular,
    )
    if OCCLUSION in rows:
        linear = linear + albedo / pi * (rows[OCCLUSION] @ light)
    return display_from_linear(linear), normals


def render(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "4 3"] | None,
) -> Rendering:
    """Render the scene.

    Args:
        model: The scene.
        camera: Where from.
        light: SH environment light, linear.
        sky_light: Sky coefficients (Eq. 11); None paints the sky white, as the protocol of
            test views does.
    """
    foreground, normals = foreground_colours(model, camera, light)
    if sky_light is None:
        sky = torch.ones(len(model.sky.rows), 3)
    else:
        sky = model.sky.colours(sky_light, camera.centre)
    return render_features(model, camera, torch.cat([foreground, sky]), normals)


def render_features(
    model: SceneModel,
    camera: Camera,
    colours: Float[Tensor, "n 3"],
    normals: Float[Tensor, "f 3"],
) -> Rendering:
    """Composite given per-Gaussian colours (both sets) with everything the losses need."""
    num_foreground, num_sky = len(model.foreground), len(model.sky.rows)
    means = torch.cat([model.foreground["means"], model.sky.means()])
    cam_from_world = camera.cam_from_world.float()
    depths = means @ cam_from_world[2, :3] + cam_from_world[2, 3]
    sums = colours.detach().sum(-1)
    is_sky = torch.cat([torch.zeros(num_foreground), torch.ones(num_sky)])
    features = torch.cat(
        [
            colours,
            depths[:, None],
            torch.cat([normals, torch.zeros(num_sky, 3)]),
            (sums * (1 - is_sky))[:, None],
            (sums * is_sky)[:, None],
        ],
        dim=-1,
    )
    result = rasterize(
        means,
        torch.cat([model.foreground["quaternions"], model.sky.rows["quaternions"]]),
        torch.cat([model.foreground["log_scales"], model.sky.rows["log_scales"]]).exp(),
        torch.cat([model.foreground["opacity_logits"], model.sky.rows["opacity_logits"]]).sigmoid(),
        features,
        cam_from_world,
        camera.intrinsics,
        camera.width,
        camera.height,
        num_feature_gradients=NUM_COLOUR_GRADIENTS,
    )
    # One split: five slices would each fill a whole picture of zeros in the backward pass.
    colour, depth, normal, foreground, sky = torch.split(result.features, CHANNELS, dim=-1)
    return Rendering(
        colour,
        result.alpha,
        depth.squeeze(-1) / result.alpha.clamp_min(SMALLEST_ALPHA),
        normal,
        foreground.squeeze(-1),
        sky.squeeze(-1),
        result.radii_px,
        result.means2d,
        depths,
    )
