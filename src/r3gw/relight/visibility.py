"""Which points of a scene a photo sees."""

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.relight.gaussians import Relightable

DEPTH_TOLERANCE = 0.05  # a point is seen if it lies at most this share behind the picture's depth
SMALLEST_ALPHA = 1e-3
LONGEST_SIDE_PX = 320


@torch.no_grad()
def is_seen(
    gaussians: Relightable, camera: Camera, points: Float[Tensor, "p 3"]
) -> Bool[Tensor, "p"]:
    """Whether a photo sees points: inside its picture, and no further away than what it shows.

    Args:
        gaussians: The scene, which hides what is behind its surfaces.
        camera: The photo's.
        points: Places in world coordinates.

    Returns:
        True where the photo sees the point.
    """
    scale = min(1.0, LONGEST_SIDE_PX / max(camera.width, camera.height))
    small = camera.scaled(round(camera.width * scale), round(camera.height * scale))
    pose = small.cam_from_world.float()
    depths = gaussians.means @ pose[2, :3] + pose[2, 3]
    features = torch.stack([depths, torch.ones_like(depths)], dim=-1)
    image = gaussians.drawn(features, small).features
    shown = image[..., 0] / image[..., 1].clamp_min(SMALLEST_ALPHA)
    local = points @ pose[:3, :3].T + pose[:3, 3]
    fx, fy, cx, cy = small.intrinsics
    z = local[:, 2].clamp_min(1e-6)
    column = (fx * local[:, 0] / z + cx).floor().long()
    row = (fy * local[:, 1] / z + cy).floor().long()
    inside = (local[:, 2] > 0) & (column >= 0) & (column < small.width)
    inside &= (row >= 0) & (row < small.height)
    depth = shown[row.clamp(0, small.height - 1), column.clamp(0, small.width - 1)]
    is_seen: Tensor = inside & (local[:, 2] <= depth * (1 + DEPTH_TOLERANCE))
    return is_seen
