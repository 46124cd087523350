"""Pinhole cameras: x right, y down, z forward; pixel centres at +0.5; the world's up is -y."""

from dataclasses import dataclass

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


def pixel_rays(camera: Camera) -> Float[Tensor, "h w 3"]:
    """Directions of the pixel centres in the camera frame, z = 1, float32."""
    fx, fy, cx, cy = camera.intrinsics
    x = (torch.arange(camera.width, dtype=torch.float32) + 0.5 - cx) / fx
    y = (torch.arange(camera.height, dtype=torch.float32) + 0.5 - cy) / fy
    down, right = torch.meshgrid(y, x, indexing="ij")
    return torch.stack([right, down, torch.ones_like(right)], dim=-1)
