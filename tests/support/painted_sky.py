"""Photos of the sky alone, painted for a sun that is known."""

from math import cos, radians, sin

import torch

from r3gw.geometry.cameras import Camera
from r3gw.imaging.colour import display_from_linear
from r3gw.training.visible_sky import VisibleSky, visible_sky


def direction(elevation_deg: float, azimuth_deg: float) -> torch.Tensor:
    """Unit vector to a sun whose azimuth counts from +z towards +x."""
    elevation, azimuth = radians(elevation_deg), radians(azimuth_deg)
    level = cos(elevation)
    return torch.tensor([level * sin(azimuth), -sin(elevation), level * cos(azimuth)])


def seen_sky(heading_deg: float, radiance_of) -> VisibleSky:
    """What a camera sees that looks a little upwards; noise of 2 %."""
    ahead = direction(20.0, heading_deg).double()
    camera = Camera.looking_at(ahead, position=torch.zeros(3).double(), width=60, height=40)
    rows, columns = torch.meshgrid(torch.arange(40) + 0.5, torch.arange(60) + 0.5, indexing="ij")
    fx, fy, cx, cy = camera.intrinsics
    rays = torch.stack([(columns - cx) / fx, (rows - cy) / fy, torch.ones(40, 60)], dim=-1)
    looks = torch.nn.functional.normalize(rays, dim=-1) @ camera.cam_from_world[:3, :3].float()
    shown = radiance_of(looks.reshape(-1, 3))[:, None] * torch.tensor([0.7, 0.9, 1.3])
    noise = 1 + 0.02 * torch.randn(shown.shape, generator=torch.Generator().manual_seed(0))
    planes = (255 * display_from_linear(shown * noise)).round().to(torch.uint8)
    found = visible_sky(camera, planes.T.reshape(3, 40, 60), torch.ones(40, 60, dtype=torch.bool))
    assert found is not None
    return found
