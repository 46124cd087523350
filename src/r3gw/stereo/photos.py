"""Photos as stereo compares them: grey, small, with what is known of each before."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.imaging.files import read_rgb
from r3gw.masks.folder import load_masks
from r3gw.scene import View

LONGER_SIDE_PX = 400  # of a photo when it is compared


class Projected(NamedTuple):
    """Points as a camera sees them.

    Attributes:
        x, y: Pixels.
        depth: Camera z, world units.
        is_inside: Whether a point is before the camera and within its picture.
    """

    x: Float[Tensor, "n"]
    y: Float[Tensor, "n"]
    depth: Float[Tensor, "n"]
    is_inside: Bool[Tensor, "n"]


@dataclass(frozen=True)
class StereoPhoto:
    """One photo, scaled down.

    Attributes:
        camera: The camera of the scaled photo.
        grey: 0 to 1.
        is_matched: False on sky and on occluders.
        known: The scene's sparse points as this photo's camera sees them.
        has_sky: Whether any sky is marked in it; if not, some of it may be sky all the same.
    """

    camera: Camera
    grey: Float[Tensor, "h w"]
    is_matched: Bool[Tensor, "h w"]
    known: Projected
    has_sky: bool = True

    @property
    def known_depths(self) -> Float[Tensor, "k"]:
        """Depths of the sparse points that lie in the picture."""
        return self.known.depth[self.known.is_inside]


def read_stereo_photo(
    view: View, scene_folder: Path, masks_folder: Path, points: Float[Tensor, "n 3"]
) -> StereoPhoto:
    """Read a photo and its masks, scaled to at most `LONGER_SIDE_PX`.

    Args:
        view: Which photo.
        scene_folder: The imported scene.
        masks_folder: Its masks.
        points: The scene's sparse points, world, float64.

    Raises:
        InputError: If photo or masks are missing or unreadable.
    """
    factor = min(1.0, LONGER_SIDE_PX / max(view.width, view.height))
    width, height = (max(1, round(side * factor)) for side in (view.width, view.height))
    camera = view.camera.scaled(width, height)
    grey = cv2.cvtColor(read_rgb(scene_folder / view.image), cv2.COLOR_RGB2GRAY)
    is_valid, is_sky = load_masks(masks_folder, view)
    return StereoPhoto(
        camera,
        torch.from_numpy(_scaled(grey, width, height)).float() / 255.0,
        torch.from_numpy(_scaled((is_valid & ~is_sky).astype(np.uint8) * 255, width, height) > 127),
        projected(points, camera),
        bool(is_sky.any()),
    )


def projected(points: Float[Tensor, "n 3"], camera: Camera) -> Projected:
    """World points, float64, in a camera's picture."""
    pose = camera.cam_from_world
    seen = points @ pose[:3, :3].T + pose[:3, 3]
    fx, fy, cx, cy = camera.intrinsics
    depth = seen[:, 2]
    x, y = fx * seen[:, 0] / depth + cx, fy * seen[:, 1] / depth + cy
    is_inside = (depth > 0) & (x >= 0) & (y >= 0) & (x < camera.width) & (y < camera.height)
    return Projected(x, y, depth, is_inside)


def lifted(
    depth: Float[Tensor, "h w"], chosen: Bool[Tensor, "h w"], camera: Camera
) -> Float[Tensor, "n 3"]:
    """World positions, float64, of the chosen pixels at their depths (camera z)."""
    seen = (pixel_rays(camera) * depth[..., None])[chosen].double()
    pose = camera.cam_from_world
    return (seen - pose[:3, 3]) @ pose[:3, :3]


def _scaled(pixels: np.ndarray, width: int, height: int) -> np.ndarray:
    scaled: np.ndarray = cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA)
    return scaled
