"""Phones and cameras with lenses: photos as they left the device, beside the undistorted ones.

Every device has one SIMPLE_RADIAL lens (COLMAP's model: ``x_d = x_u (1 + k r_u^2)`` in units of the
focal length). An original is resampled from the rendered pinhole picture, so it shows nothing that
the pinhole picture does not: where a lens squeezes the picture, the original is a little smaller.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from r3gw.geometry.cameras import Camera

Pixels = NDArray[np.uint8]


@dataclass(frozen=True)
class Device:
    """One device of those that took a scene's photos.

    Attributes:
        share: Width and height of its pinhole pictures, as shares of the scene's nominal size.
        focal: Focal length in nominal widths.
        distortion: ``k`` of SIMPLE_RADIAL.
        original_share: Width and height of its originals, as shares of its pinhole pictures.
    """

    share: tuple[float, float]
    focal: float
    distortion: float
    original_share: float

    def camera(self, posed: Camera, size_px: tuple[int, int]) -> Camera:
        """This device at the place of ``posed``; ``size_px`` is the scene's nominal size."""
        width, height = (round(s * n) for s, n in zip(self.share, size_px, strict=True))
        focal_px = self.focal * size_px[0]
        intrinsics = (focal_px, focal_px, width / 2, height / 2)
        return Camera(posed.cam_from_world, intrinsics, width, height)

    def original_size(self, camera: Camera) -> tuple[int, int]:
        """Width and height of an original in pixels."""
        return round(self.original_share * camera.width), round(self.original_share * camera.height)

    def distorted(self, pixels: NDArray[np.float64], camera: Camera) -> NDArray[np.float64]:
        """Where pixels ``[n, 2]`` of the pinhole picture lie in the original."""
        focal_px, _, cx, cy = camera.intrinsics
        width, height = self.original_size(camera)
        local = (pixels - (cx, cy)) / focal_px
        radius2 = (local**2).sum(axis=1, keepdims=True)
        return np.asarray(
            local * (1 + self.distortion * radius2) * focal_px + (width / 2, height / 2)
        )

    def original(self, photo: Pixels, camera: Camera) -> Pixels:
        """The photo ``[h, w, 3]`` as it left the device."""
        focal_px, _, cx, cy = camera.intrinsics
        width, height = self.original_size(camera)
        x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        target = np.stack([(x - width / 2) / focal_px, (y - height / 2) / focal_px], axis=-1)
        local = self._undistorted(target)
        # OpenCV counts pixel centres from 0.
        column = (local[..., 0] * focal_px + cx - 0.5).astype(np.float32)
        row = (local[..., 1] * focal_px + cy - 0.5).astype(np.float32)
        resampled = cv2.remap(photo, column, row, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(resampled, dtype=np.uint8)

    def _undistorted(self, target: NDArray[np.float64]) -> NDArray[np.float64]:
        """Invert the lens by fixed-point steps; the lenses here are weak, so ten are exact."""
        local = target.copy()
        for _ in range(10):
            local = target / (1 + self.distortion * (local**2).sum(axis=-1, keepdims=True))
        return local


# Three phones held level and one held upright.
DEVICES = (
    Device((1.0, 1.0), 0.95, 0.045, 1.0),
    Device((1.0, 1.0035), 1.05, -0.035, 0.96),
    Device((0.996, 1.0), 0.88, 0.02, 1.0),
    Device((0.6641, 1.4118), 0.92, -0.025, 0.96),
)
