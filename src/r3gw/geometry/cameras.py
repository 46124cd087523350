"""Pinhole cameras: x right, y down, z forward; pixel centres at +0.5; the world's up is -y."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians, tan

import torch
from jaxtyping import Float
from torch import Tensor

UP = (0.0, -1.0, 0.0)


@dataclass(frozen=True)
class Camera:
    """One photo's camera.

    Attributes:
        cam_from_world: Rigid transform ``[4, 4]``, float64, on the CPU wherever the scene lies:
            kernels read it as numbers.
        intrinsics: ``(fx, fy, cx, cy)`` in pixels.
        width: Picture width in pixels.
        height: Picture height in pixels.
    """

    cam_from_world: Float[Tensor, "4 4"]
    intrinsics: tuple[float, float, float, float]
    width: int
    height: int

    @staticmethod
    def looking_at(
        target: Sequence[float] | Float[Tensor, "3"],
        *,
        position: Sequence[float] | Float[Tensor, "3"],
        fov_deg: float = 50.0,
        width: int = 640,
        height: int = 480,
    ) -> "Camera":
        """An upright camera that has a point in the middle of its picture.

        Args:
            target: The point, in world coordinates (up is -y).
            position: Of the camera; not straight above or below the target.
            fov_deg: Angle from the left to the right edge.
            width: Picture width in pixels.
            height: Picture height in pixels.

        Raises:
            ValueError: If the direction of view is vertical or has no length.
        """
        towards = torch.as_tensor(target, dtype=torch.float64)
        from_here = torch.as_tensor(position, dtype=torch.float64)
        focal = 0.5 * width / tan(0.5 * radians(fov_deg))
        intrinsics = (focal, focal, width / 2, height / 2)
        return Camera(upright_pose(towards, from_here), intrinsics, width, height)

    @property
    def centre(self) -> Float[Tensor, "3"]:
        """Camera position in the world."""
        return -self.cam_from_world[:3, :3].T @ self.cam_from_world[:3, 3]

    def scaled(self, width: int, height: int) -> "Camera":
        """The same camera for its picture scaled to ``width`` x ``height`` pixels."""
        fx, fy, cx, cy = self.intrinsics
        right, down = width / self.width, height / self.height
        intrinsics = (fx * right, fy * down, cx * right, cy * down)
        return Camera(self.cam_from_world, intrinsics, width, height)


def upright_pose(target: Float[Tensor, "3"], position: Float[Tensor, "3"]) -> Float[Tensor, "4 4"]:
    """``cam_from_world`` of a level camera at ``position`` that looks at ``target``, float64.

    Raises:
        ValueError: If the direction of view is vertical or has no length.
    """
    forward = torch.nn.functional.normalize(target - position, dim=0)
    right = torch.linalg.cross(-torch.tensor(UP, dtype=torch.float64), forward)
    if right.norm() < 1e-9:
        raise ValueError("an upright camera cannot look straight up or down")
    right = torch.nn.functional.normalize(right, dim=0)
    cam_from_world = torch.eye(4, dtype=torch.float64)
    cam_from_world[:3, :3] = torch.stack([right, torch.linalg.cross(forward, right), forward])
    cam_from_world[:3, 3] = -cam_from_world[:3, :3] @ position
    return cam_from_world


def pixel_rays(camera: Camera) -> Float[Tensor, "h w 3"]:
    """Directions of the pixel centres in the camera frame, z = 1, float32."""
    fx, fy, cx, cy = camera.intrinsics
    x = (torch.arange(camera.width, dtype=torch.float32) + 0.5 - cx) / fx
    y = (torch.arange(camera.height, dtype=torch.float32) + 0.5 - cy) / fy
    down, right = torch.meshgrid(y, x, indexing="ij")
    return torch.stack([right, down, torch.ones_like(right)], dim=-1)


def pixel_directions(camera: Camera) -> Float[Tensor, "h w 3"]:
    """Unit world directions that the pixel centres look in, float32."""
    rays = pixel_rays(camera) @ camera.cam_from_world[:3, :3].float()
    return torch.nn.functional.normalize(rays, dim=-1)
