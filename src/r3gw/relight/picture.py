"""One frame: shade, rasterize four channels, put the sky behind.

The fourth channel is the opacity of what has a colour of its own. A learned sky colours the sky's
Gaussians, as in training. A white sky or an environment map is seen per pixel instead: there the
sky's Gaussians only hide what is behind them, and the pixel's own background shows through them.
"""

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.raster import rasterize
from r3gw.relight.gaussians import Relightable
from r3gw.relight.tone import Curve
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


def pixel_directions(camera: Camera) -> Float[Tensor, "h w 3"]:
    """Unit world directions that a camera's pixels look in, float32."""
    rays = pixel_rays(camera) @ camera.cam_from_world[:3, :3].float()
    return torch.nn.functional.normalize(rays, dim=-1)


@torch.no_grad()
def frame(
    gaussians: Relightable, camera: Camera, light: Light, curve: Curve
) -> Float[Tensor, "h w 3"]:
    """One picture, in the values of the tone curve; what nothing covers shows the sky."""
    colours = foreground_values(gaussians, camera.centre, light, curve)
    if isinstance(light.sky, LearnedSky):
        sky = sky_values(gaussians, camera.centre, light, curve)
        features = torch.nn.functional.pad(torch.cat([colours, sky]), (0, 1), value=1.0)
    else:
        features = torch.zeros(len(gaussians.means), 4)
        features[: gaussians.num_foreground, :3] = colours
        features[: gaussians.num_foreground, 3] = 1.0
    image = rasterize(
        gaussians.means,
        gaussians.quaternions,
        gaussians.scales,
        gaussians.opacities,
        features,
        camera.cam_from_world.float(),
        camera.intrinsics,
        camera.width,
        camera.height,
    ).features
    behind = seen_sky(light, pixel_directions(camera), curve)
    return image[..., :3] + (1.0 - image[..., 3:]) * behind
