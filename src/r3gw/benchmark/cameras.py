"""Where visitors stood: hand-held pinhole cameras along an arc, and test views in between."""

from math import radians

import numpy as np
import torch
from numpy.typing import NDArray

from r3gw.benchmark.place import Walk
from r3gw.geometry.cameras import Camera

Array = NDArray[np.float64]

# World axes of the building axes: x stays, away from the street is +z, up is -y.
WORLD_FROM_BUILDING = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])

# The last bit of a product of matrices depends on where in memory they lie. Poses are rounded well
# above that bit and far below what a picture shows, so that every run writes the same ones.
POSE_DECIMALS = 12


def train_cameras(
    walk: Walk, count: int, size_px: tuple[int, int], random: np.random.Generator
) -> list[Camera]:
    """Cameras evenly along the arc with hand-held scatter, from one end to the other."""
    middles = (np.arange(count) + 0.5) / count * 2 - 1
    return [_stand(walk, float(middle), count, size_px, random) for middle in middles]


def test_cameras(
    walk: Walk, count: int, trained: list[Camera], random: np.random.Generator
) -> list[Camera]:
    """Cameras between neighbouring training cameras, spread over the arc."""
    cameras = []
    for i in range(count):
        gap = (i + 0.5) / count * (len(trained) - 1)
        left = trained[min(int(gap), len(trained) - 1)]
        right = trained[min(int(gap) + 1, len(trained) - 1)]
        share = float(random.uniform(0.35, 0.65))
        spot = (1 - share) * left.centre.numpy() + share * right.centre.numpy()
        spot = spot + random.uniform(-0.15, 0.15, 3) * np.array([1.0, 0.3, 1.0])
        focal = (left.intrinsics[0] + right.intrinsics[0]) / 2
        size = (left.width, left.height)
        cameras.append(_aimed(walk, spot, focal, size, random))
    return cameras


def _stand(
    walk: Walk, along: float, count: int, size_px: tuple[int, int], random: np.random.Generator
) -> Camera:
    """A camera at a place of the arc, -1 the left end and 1 the right end."""
    jitter = 0.6 * walk.arc_deg / count
    angle = radians(walk.arc_deg * along + random.uniform(-jitter, jitter))
    reach = random.uniform(walk.near, walk.far)
    eye = walk.eye + random.uniform(-0.12, 0.16)
    level = np.array([np.sin(angle), -np.cos(angle), 0.0])
    spot = np.array([walk.focus[0], walk.focus[1], 0.0]) + reach * level + [0.0, 0.0, eye]
    focal = random.uniform(*walk.focal) * size_px[0]
    return _aimed(walk, WORLD_FROM_BUILDING @ spot, focal, size_px, random)


def _aimed(
    walk: Walk, spot: Array, focal: float, size_px: tuple[int, int], random: np.random.Generator
) -> Camera:
    """A camera at a world position that looks about at the focus, slightly tilted."""
    scatter = random.uniform(-0.45, 0.45, 3) * np.array([1.0, 1.0, 0.6])
    target = WORLD_FROM_BUILDING @ (np.asarray(walk.focus) + scatter)
    forward = (target - spot) / np.linalg.norm(target - spot)
    roll = radians(random.normal(0.0, 0.8))
    right = np.cross([0.0, 1.0, 0.0], forward)
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    right = np.cos(roll) * right + np.sin(roll) * down
    down = np.cross(forward, right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, down, forward])
    pose[:3, 3] = -pose[:3, :3] @ spot
    width, height = size_px
    shift = random.uniform(-0.012, 0.012, 2) * (random.uniform() < 0.5)
    intrinsics = (focal, focal, width * (0.5 + shift[0]), height * (0.5 + shift[1]))
    rounded = tuple(float(np.round(value, 4)) for value in intrinsics)
    fx, fy, cx, cy = rounded
    return Camera(torch.from_numpy(pose.round(POSE_DECIMALS)), (fx, fy, cx, cy), width, height)
