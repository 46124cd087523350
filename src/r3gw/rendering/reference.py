"""What `r3gw.rendering.splats` computes, in plain torch; it works in float64 too."""

from math import pi

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize, pad

from r3gw.geometry.cameras import Camera
from r3gw.geometry.rotations import shortest_axes
from r3gw.imaging.colour import display_from_linear
from r3gw.model.attributes import LOG_SCALES, OPACITY, materials_of
from r3gw.model.model import SceneModel
from r3gw.rendering.channels import CHANNELS, Layers
from r3gw.rendering.cook_torrance import face_camera, shade
from r3gw.rendering.splat_set import Splats, irradiance_beside


def splats_of(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "4 3"] | None,
    layers: Layers = Layers.COLOUR,
    beside: Float[Tensor, "f 3"] | None = None,
) -> Splats:
    """As `r3gw.rendering.splats.splats_of`."""
    foreground, sky = model.foreground, model.sky
    means = torch.cat([foreground["means"], sky.means()])
    to_camera = normalize(camera.centre.to(means) - foreground["means"], dim=-1).detach()
    normals = face_camera(
        shortest_axes(foreground["quaternions"], foreground["log_scales"]), to_camera
    )
    materials = materials_of(foreground)
    linear = shade(
        normals, to_camera, **materials, light=light, with_specular=model.description.specular
    )
    if beside is None:
        beside = irradiance_beside(foreground, light, None)
    if beside is not None:
        linear = linear + materials["albedo"] * beside / pi
    colours = display_from_linear(linear)
    if sky_light is None:
        sky_colours = torch.ones_like(means[len(foreground) :])
    else:
        sky_colours = sky.colours(sky_light, camera.centre)
    scales = torch.cat([LOG_SCALES.of(foreground), LOG_SCALES.of(sky.rows)])
    opacities = torch.cat([OPACITY.of(foreground), OPACITY.of(sky.rows)])
    pose = camera.cam_from_world.to(means)
    depths = means @ pose[2, :3] + pose[2, 3]
    rows = len(foreground), len(sky.rows)
    by_name = {
        "colour": torch.cat([colours, sky_colours]),
        "depth": depths[:, None],
        "normal": pad(normals, (0, 0, 0, rows[1])),
        "foreground": pad(_layer(colours, layers), (0, rows[1]))[:, None],
        "sky": pad(_layer(sky_colours, layers), (rows[0], 0))[:, None],
    }
    features = torch.cat([by_name[name] for name in CHANNELS], dim=-1)
    return Splats(
        means,
        torch.cat([foreground["quaternions"], sky.rows["quaternions"]]),
        scales,
        opacities,
        features,
        depths,
        scales[: rows[0]].amin(dim=-1),
        layers,
    )


def _layer(colours: Float[Tensor, "n 3"], layers: Layers) -> Float[Tensor, "n"]:
    """What a set's own channel holds of each of its Gaussians."""
    return colours.detach().sum(-1) if layers is Layers.COLOUR else torch.ones_like(colours[:, 0])
