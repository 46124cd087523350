"""One frame: shade, rasterize four channels, put the sky behind.

The fourth channel is the foreground's opacity. A learned sky colours the sky's Gaussians, as in
training. A white sky or an environment map is seen per pixel instead, in place of the sky's
Gaussians. What neither set covers is sky or black (`r3gw.relight.uncovered`).
"""

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.geometry.cameras import Camera, pixel_directions
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.relight.gaussians import Relightable
from r3gw.relight.seen import dimmed
from r3gw.relight.sunlit import colours_in_sun_and_shade, reaches, sun_on
from r3gw.relight.tone import Curve
from r3gw.relight.uncovered import other_sky_seen, own_sky_behind
from r3gw.relight.witnesses import Witnesses
from r3gw.rendering.shading import shade_foreground


def foreground_values(
    gaussians: Relightable,
    camera_centre: Float[Tensor, "3"],
    light: Light,
    curve: Curve,
) -> Float[Tensor, "f 3"]:
    """Colours of the foreground as seen from a point, after the tone curve."""
    linear = shade_foreground(
        gaussians.means[: gaussians.num_foreground],
        gaussians.normals,
        gaussians.albedo,
        gaussians.roughness,
        camera_centre,
        light.sh,
        with_specular=gaussians.with_specular,
        occlusion=gaussians.occlusion,
    )
    return curve(linear)


def sky_values(
    gaussians: Relightable, camera_centre: Float[Tensor, "3"], light: Light, curve: Curve
) -> Float[Tensor, "s 3"]:
    """Colours of the sky's Gaussians as seen from a point, after the tone curve."""
    means = gaussians.means[gaussians.num_foreground :]
    looks = torch.nn.functional.normalize(means - camera_centre.to(means), dim=-1)
    return seen_sky(light, looks, curve)


def seen_sky(
    light: Light, directions: Float[Tensor, "*batch 3"], curve: Curve
) -> Float[Tensor, "*batch 3"]:
    """What a light's sky shows in some directions, after the tone curve; no sky is paper white."""
    if light.sky is None:
        return torch.ones_like(directions)
    return curve(light.sky.radiance(directions))


@torch.no_grad()
def frame(
    gaussians: Relightable,
    camera: Camera,
    light: Light,
    curve: Curve,
    witnesses: Witnesses | None = None,
    dim_but: Bool[Tensor, "f"] | None = None,
) -> Float[Tensor, "h w 3"]:
    """One picture, in the values of the tone curve.

    Args:
        gaussians: The trained scene.
        camera: Where from.
        light: What lights the scene, and the sky that is seen.
        curve: From linear values to those of the picture.
        witnesses: The training photos, which know some uncovered places to be dark; None if their
            cameras are unknown.
        dim_but: True for the foreground Gaussians that stay as they are, where the others are
            shown dark (`r3gw.relight.seen.dimmed`); None dims none.
    """
    has_own_sky = isinstance(light.sky, LearnedSky)
    features = torch.zeros(len(gaussians.means), 4)
    colours = sunlit_values(gaussians, camera, light, curve)
    features[: gaussians.num_foreground, :3] = (
        colours if dim_but is None else dimmed(colours, dim_but)
    )
    features[: gaussians.num_foreground, 3] = 1.0
    if has_own_sky:
        features[gaussians.num_foreground :, :3] = sky_values(
            gaussians, camera.centre, light, curve
        )
    drawn = gaussians.drawn(features, camera)
    foreground = drawn.features[..., 3:]
    sky = (drawn.alpha[..., None] - foreground).clamp_min(0.0)
    dark = torch.zeros_like(sky) if witnesses is None else witnesses.darkness(camera)
    weight = own_sky_behind if has_own_sky else other_sky_seen
    behind = seen_sky(light, pixel_directions(camera), curve)
    return drawn.features[..., :3] + weight(foreground, sky, dark) * behind


def sunlit_values(
    gaussians: Relightable, camera: Camera, light: Light, curve: Curve
) -> Float[Tensor, "f 3"]:
    """Colours of the foreground as a camera sees it, with the shadows of a sun."""
    sun = sun_on(gaussians, light)
    if sun is None:
        return foreground_values(gaussians, camera.centre, light, curve)
    in_sun, in_shade = colours_in_sun_and_shade(gaussians, camera.centre, light, sun, curve)
    return torch.lerp(in_shade, in_sun, reaches(gaussians, [camera], sun)[:, None])
