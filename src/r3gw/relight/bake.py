"""Colours that do not change with the view, for formats without light."""

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.lighting.light import Light
from r3gw.relight.files.ply import Baked
from r3gw.relight.gaussians import Relightable
from r3gw.relight.picture import foreground_values, sky_values
from r3gw.relight.sunlit import colours_in_sun_and_shade, reaches, sun_on
from r3gw.relight.tone import Curve
from r3gw.rendering.cook_torrance import face_camera


@torch.no_grad()
def bake(gaussians: Relightable, cameras: list[Camera], light: Light, curve: Curve) -> Baked:
    """Mean, over the cameras, of the colour in which each one sees each Gaussian.

    The mean is the constant colour with the least squared error over these cameras. With one
    camera, its picture is exact, but for a sun's shadows, which are as sharp as Gaussians are
    small. Normals are turned to the cameras' middle.
    """
    total = torch.zeros(len(gaussians.means), 3)
    sun = sun_on(gaussians, light)
    lit = None if sun is None else reaches(gaussians, cameras, sun)[:, None]
    for camera in cameras:
        if sun is None or lit is None:
            foreground = foreground_values(gaussians, camera.centre, light, curve)
        else:
            both = colours_in_sun_and_shade(gaussians, camera.centre, light, sun, curve)
            foreground = torch.lerp(both[1], both[0], lit)
        total += torch.cat([foreground, sky_values(gaussians, camera.centre, light, curve)])
    middle = torch.stack([camera.centre for camera in cameras]).mean(dim=0)
    return Baked((total / len(cameras)).clamp(0.0, 1.0), _normals(gaussians, middle))


def _normals(gaussians: Relightable, middle: Float[Tensor, "3"]) -> Float[Tensor, "n 3"]:
    means = gaussians.means[: gaussians.num_foreground]
    facing = face_camera(gaussians.normals, middle.to(means) - means)
    return torch.nn.functional.pad(facing, (0, 0, 0, gaussians.num_sky))
