"""What `r3gw.rendering.splats` computes, in plain torch; it works in float64 too."""

from math import pi

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize, pad

from r3gw.geometry.cameras import Camera
from r3gw.geometry.rotations import shortest_axes
from r3gw.imaging.colour import display_from_linear
from r3gw.model.model import SceneModel
from r3gw.rendering.cook_torrance import face_camera, shade
from r3gw.rendering.splats import Splats, shadows_of


def splats_of(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "4 3"] | None,
) -> Splats:
    """As `r3gw.rendering.splats.splats_of`."""
    foreground, sky = model.foreground, model.sky
    means = torch.cat([foreground["means"], sky.means()])
    to_camera = normalize(camera.centre.to(means) - foreground["means"], dim=-1).detach()
    normals = face_camera(
        shortest_axes(foreground["quaternions"], foreground["log_scales"]), to_camera
    )
    linear = shade(
        normals,
        to_camera,
        foreground["albedo_logits"].sigmoid(),
        foreground["roughness_logits"].sigmoid(),
        light,
        with_specular=model.description.specular,
    )
    for shadow in shadows_of(foreground, light):
        linear = linear + foreground["albedo_logits"].sigmoid() * shadow / pi
    colours = display_from_linear(linear)
    if sky_light is None:
        sky_colours = torch.ones_like(means[len(foreground) :])
    else:
        sky_colours = sky.colours(sky_light, camera.centre)
    log_scales = torch.cat([foreground["log_scales"], sky.rows["log_scales"]])
    opacity_logits = torch.cat([foreground["opacity_logits"], sky.rows["opacity_logits"]])
    pose = camera.cam_from_world.to(means)
    depths = means @ pose[2, :3] + pose[2, 3]
    rows = len(foreground), len(sky.rows)
    features = torch.cat(
        [
            torch.cat([colours, sky_colours]),
            depths[:, None],
            pad(normals, (0, 0, 0, rows[1])),
            pad(colours.detach().sum(-1), (0, rows[1]))[:, None],
            pad(sky_colours.detach().sum(-1), (rows[0], 0))[:, None],
        ],
        dim=-1,
    )
    return Splats(
        means,
        torch.cat([foreground["quaternions"], sky.rows["quaternions"]]),
        log_scales.exp(),
        opacity_logits.sigmoid(),
        features,
        depths,
        foreground["log_scales"].exp().amin(dim=-1),
    )
