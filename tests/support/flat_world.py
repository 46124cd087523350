"""A flat, grey-red world under a blue sky: two small photos and the points to train it from."""

import torch

from r3gw.geometry.cameras import Camera
from r3gw.model.initial import InitialPoints
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.training.photos import Photo

NAMES = ("a", "b")


def flat_photos() -> list[Photo]:
    """Two views, 32 x 24 pixels; the upper third is sky."""
    found = []
    for name, shift in zip(NAMES, (0.0, 0.4), strict=True):
        cam_from_world = torch.eye(4, dtype=torch.float64)
        cam_from_world[0, 3] = shift
        camera = Camera(cam_from_world, (30.0, 30.0, 16.0, 12.0), 32, 24)
        planes = torch.empty(3, 24, 32, dtype=torch.uint8)
        planes[:, :8] = torch.tensor([90, 140, 220], dtype=torch.uint8)[:, None, None]
        planes[:, 8:] = torch.tensor([150, 90, 80], dtype=torch.uint8)[:, None, None]
        is_sky = torch.zeros(24, 32, dtype=torch.bool)
        is_sky[:8] = True
        found.append(Photo(name, camera, planes, torch.ones(24, 32, dtype=torch.bool), is_sky))
    return found


def flat_points() -> InitialPoints:
    """150 points in a slab before the cameras, 200 on the dome."""
    generator = torch.Generator().manual_seed(0)
    points = torch.rand(150, 3, generator=generator) * torch.tensor([6.0, 2.4, 0.2])
    points += torch.tensor([-3.0, -0.5, 4.0])
    dome = SkyDome(torch.tensor([0.0, 0.5, 0.0]), 8.0, (-1.0, 1.0))
    return InitialPoints(points, dome, sample_dome(dome, 200, generator))
