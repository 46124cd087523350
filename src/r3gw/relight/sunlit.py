"""A trained scene in the sun: its colours with and without it, and what stands in it."""

from collections.abc import Sequence
from math import pi

from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize

from r3gw.geometry.cameras import Camera
from r3gw.lighting.light import Light
from r3gw.lighting.sh import degree_of
from r3gw.lighting.sun import PointSun
from r3gw.relight.gaussians import Relightable
from r3gw.relight.tone import Curve
from r3gw.rendering.cook_torrance import face_camera
from r3gw.rendering.shading import shade_foreground
from r3gw.rendering.sun_shadow import Gaussians, reach, sun_shadow
from r3gw.rendering.sunlight import bounced_irradiance, sun_radiance


def sun_on(gaussians: Relightable, light: Light) -> PointSun | None:
    """The part of a light's sun that a scene is shaded with; None for the light's SH alone."""
    if light.point is None or not gaussians.has_point_sun:
        return None
    return light.point.times(gaussians.sharp)


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


def reaches(gaussians: Relightable, cameras: Sequence[Camera], sun: PointSun) -> Float[Tensor, "f"]:
    """Share of the sun that reaches each foreground Gaussian, as cameras see it.

    Args:
        gaussians: The scene.
        cameras: One for its picture, several for colours that are to suit all of them.
        sun: The sun.
    """
    count = gaussians.num_foreground
    everything = (gaussians.means, gaussians.quaternions, gaussians.scales, gaussians.opacities)
    foreground = Gaussians(*(each[:count] for each in everything))
    return reach(foreground, cameras, sun_shadow(foreground, sun.direction))
