"""Similarity transforms: ``x_target = scale * rotation @ x_source + translation``."""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor


@dataclass(frozen=True)
class Similarity:
    """A similarity transform ``target_from_source``.

    Attributes:
        scale: Factor > 0.
        rotation: ``[3, 3]``, float64.
        translation: ``[3]``, float64, in target units.
    """

    scale: float
    rotation: Float[Tensor, "3 3"]
    translation: Float[Tensor, "3"]

    @staticmethod
    def identity() -> "Similarity":
        """The transform that changes nothing."""
        return Similarity(
            1.0, torch.eye(3, dtype=torch.float64), torch.zeros(3, dtype=torch.float64)
        )

    def points(self, points: Float[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
        """Map points; the result has the points' dtype."""
        moved = self.scale * points.double() @ self.rotation.T + self.translation
        return moved.to(points.dtype)

    def camera(self, cam_from_source: Float[Tensor, "4 4"]) -> Float[Tensor, "4 4"]:
        """Return the rigid ``cam_from_target`` of a camera; its frame is scaled with the world."""
        cam_from_target = torch.eye(4, dtype=torch.float64)
        rotation = cam_from_source[:3, :3].double() @ self.rotation.T
        cam_from_target[:3, :3] = rotation
        cam_from_target[:3, 3] = (
            self.scale * cam_from_source[:3, 3].double() - rotation @ self.translation
        )
        return cam_from_target

    def inverse(self) -> "Similarity":
        """The transform ``source_from_target``."""
        back = self.rotation.T
        return Similarity(1.0 / self.scale, back, -(back @ self.translation) / self.scale)
