"""A trained scene in the sun: its colours with and without it, and what stands in it."""

from collections.abc import Sequence
from math import pi

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize

from r3gw.geometry.cameras import Camera
from r3gw.lighting.light import Light
from r3gw.lighting.sh import degree_of
from r3gw.lighting.sun import PointSun
from r3gw.relight.gaussians import Relightable
from r3gw.relight.tone import Curve
from r3gw.rendering.compose import SMALLEST_ALPHA
from r3gw.rendering.cook_torrance import face_camera
from r3gw.rendering.shading import shade_foreground
from r3gw.rendering.sun_shadow import SunShadow, sun_shadow
from r3gw.rendering.sunlight import bounced_irradiance, sun_radiance


def sun_on(gaussians: Relightable, light: Light) -> PointSun | None:
    """The part of a light's sun that a scene is shaded with; None for the light's SH alone."""
    if light.point is None or not gaussians.has_point_sun:
        return None
    return light.point.times(gaussians.sharp)


def shadow_on(gaussians: Relightable, sun: PointSun) -> SunShadow:
    """What stands in the sun."""
    count = gaussians.num_foreground
    return sun_shadow(
        gaussians.means[:count],
        gaussians.quaternions[:count],
        gaussians.scales[:count],
        gaussians.opacities[:count],
        sun.direction,
    )


def colours_in_sun_and_shade(
    gaussians: Relightable,
    camera_centre: Float[Tensor, "3"],
    light: Light,
    sun: PointSun,
    curve: Curve,
) -> tuple[Float[Tensor, "f 3"], Float[Tensor, "f 3"]]:
    """Colours of the foreground as seen from a point, as if all of it stood in the sun, or none.

    Args:
        gaussians: The scene, which is shaded with suns.
        camera_centre: Where from.
        light: All of it.
        sun: The part of it that is shaded as a sun (`sun_on`).
        curve: From linear values to those of the picture.
    """
    surfaces = (
        gaussians.means[: gaussians.num_foreground],
        gaussians.normals,
        gaussians.albedo,
        gaussians.roughness,
    )
    in_shade = shade_foreground(
        *surfaces,
        camera_centre,
        light.sh - sun.sh(degree_of(len(light.sh))),
        with_specular=gaussians.with_specular,
        occlusion=gaussians.occlusion,
    )
    if gaussians.occlusion is not None:
        bounced = bounced_irradiance(gaussians.occlusion, sun, gaussians.sun_bounce)
        in_shade = in_shade + gaussians.albedo / pi * bounced
    means, normals, albedo, roughness = surfaces
    to_camera = normalize(camera_centre.to(means) - means, dim=-1)
    facing, reflects = face_camera(normals, to_camera), gaussians.with_specular
    added = sun_radiance(facing, to_camera, albedo, roughness, sun, with_specular=reflects)
    return curve(in_shade + added), curve(in_shade)


def depth_of(depth: Float[Tensor, "h w"], alpha: Float[Tensor, "h w"]) -> Float[Tensor, "h w"]:
    """Expected camera z of pixels, from what was composited."""
    return depth / alpha.clamp_min(SMALLEST_ALPHA)


def reaches(gaussians: Relightable, cameras: Sequence[Camera], sun: PointSun) -> Float[Tensor, "f"]:
    """Share of the sun that reaches each foreground Gaussian, for colours that are baked.

    It is the mean over the pixels in which cameras see a Gaussian, weighted by how much of it they
    see, of the share that reaches the pixel. What none sees takes the share at its middle.

    Args:
        gaussians: The scene.
        cameras: Those that the colours are to suit.
        sun: The sun.
    """
    count, shadow = gaussians.num_foreground, shadow_on(gaussians, sun)
    total = torch.zeros(count, 2)
    for camera in cameras:
        depths = gaussians.means @ camera.cam_from_world[2, :3].float()
        depths = depths + float(camera.cam_from_world[2, 3])
        with torch.no_grad():
            drawn = gaussians.drawn(depths[:, None], camera)
            lit = shadow.seen_from(camera, depth_of(drawn.planes[0], drawn.alpha))
        with torch.enable_grad():
            # A Gaussian's share of a pixel is how the pixel changes with what the Gaussian holds.
            held = torch.zeros(len(gaussians.means), 2, requires_grad=True)
            planes = gaussians.drawn(held, camera).planes
            sums = (planes * torch.stack([lit, torch.ones_like(lit)])).sum()
            total += torch.autograd.grad(sums, held)[0][:count]
    is_seen = total[:, 1] > SMALLEST_ALPHA
    middle = shadow.visibility(gaussians.means[:count])
    return torch.where(is_seen, total[:, 0] / total[:, 1].clamp_min(SMALLEST_ALPHA), middle)
