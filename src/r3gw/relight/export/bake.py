"""Colours that do not change with the view, for formats without light."""

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.relight.files.ply import Baked
from r3gw.relight.picture import Illumination, foreground_values, sky_values
from r3gw.relight.scene import Relightable
from r3gw.relight.tone import Curve
from r3gw.rendering.cook_torrance import face_camera


@torch.no_grad()
def bake(splats: Relightable, cameras: list[Camera], shown: Illumination, curve: Curve) -> Baked:
    """Mean, over the cameras, of the colour in which each one sees each Gaussian.

    The mean is the constant colour with the least squared error over these cameras. With one
    camera, its picture is exact. Normals are turned to the cameras' middle.
    """
    total = torch.zeros(len(splats.means), 3)
    for camera in cameras:
        parts = [
            foreground_values(splats, camera.centre, shown.light, curve),
            sky_values(splats, camera.centre, shown, curve),
        ]
        total += torch.cat(parts)
    middle = torch.stack([camera.centre for camera in cameras]).mean(dim=0)
    return Baked((total / len(cameras)).clamp(0.0, 1.0), _normals(splats, middle))


def _normals(splats: Relightable, middle: Float[Tensor, "3"]) -> Float[Tensor, "n 3"]:
    means = splats.means[: splats.num_foreground]
    facing = face_camera(splats.normals, middle.to(means) - means)
    return torch.nn.functional.pad(facing, (0, 0, 0, splats.num_sky))
