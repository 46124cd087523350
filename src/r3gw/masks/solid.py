"""Where a photo cannot show sky: in front of it stand the points of structure from motion."""

import numpy as np
from numpy.typing import NDArray

from r3gw.scene import View

FARTHEST = 10.0  # median depths; from further away come clouds, which move too little to be told

Positions = NDArray[np.float64]


def solid_positions(view: View, xyz: NDArray[np.float32]) -> Positions:
    """Pixel positions (x, y) ``[n, 2]`` of the points that a photo looks at or through a wall at.

    Whether a point is hidden does not matter: along its ray there is no sky.

    Args:
        view: The photo.
        xyz: The scene's points, world, ``[m, 3]``.
    """
    pose = np.asarray(view.cam_from_world, dtype=np.float64)
    local = xyz.astype(np.float64) @ pose[:3, :3].T + pose[:3, 3]
    local = local[local[:, 2] > 0]
    fx, fy, cx, cy = view.intrinsics
    x = fx * local[:, 0] / local[:, 2] + cx
    y = fy * local[:, 1] / local[:, 2] + cy
    is_inside = (x >= 0) & (x < view.width) & (y >= 0) & (y < view.height)
    depth = local[is_inside, 2]
    is_near = depth <= FARTHEST * np.median(depth) if len(depth) else depth > 0
    return np.asarray(np.stack([x, y], axis=1)[is_inside][is_near])
