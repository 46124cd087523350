"""The sparse points that structure from motion would find: seen in photos, a little noisy."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from r3gw.geometry.cameras import Camera, pixel_rays

Array = NDArray[np.float64]

DEPTH_TOLERANCE = 0.02  # Relative; further off, the point is hidden in that photo
NOISE = 0.008  # Scene units per axis
FARTHEST = 11.0  # Scene units from the focus of the walk


@dataclass(frozen=True)
class View:
    """What is needed of one training photo.

    Attributes:
        camera: Its camera.
        depth: ``[H, W]`` camera z, 0 at sky.
        is_usable: ``[H, W]``, False at occluders.
        photo: ``[H, W, 3]`` uint8 RGB.
    """

    camera: Camera
    depth: NDArray[np.float32]
    is_usable: NDArray[np.bool_]
    photo: NDArray[np.uint8]


@dataclass(frozen=True)
class Points:
    """Sparse points.

    Attributes:
        xyz: ``[N, 3]`` world positions.
        rgb: ``[N, 3]`` uint8 colours.
        tracks: Per point, the photos that show it: (number of the view, x, y in pixels).
    """

    xyz: Array
    rgb: NDArray[np.uint8]
    tracks: list[list[tuple[int, float, float]]]


def find(views: Sequence[View], count: int, focus: Array, random: np.random.Generator) -> Points:
    """Draw points on surfaces near the focus that at least two views see.

    Args:
        views: Training photos.
        count: Candidates; points seen in one photo alone are dropped.
        focus: World position; points further than `FARTHEST` from it are dropped.
        random: Chooses pixels and noise.
    """
    share = -(-count // len(views))
    drawn = [_draw(view, share, random) for view in views]
    xyz = np.concatenate([points for points, _ in drawn])
    rgb = np.concatenate([colours for _, colours in drawn])
    is_near = np.linalg.norm(xyz - focus, axis=1) < FARTHEST
    xyz, rgb = xyz[is_near], rgb[is_near]
    tracks: list[list[tuple[int, float, float]]] = [[] for _ in xyz]
    for number, view in enumerate(views):
        pixels, is_seen = _project(view, xyz)
        for i in np.flatnonzero(is_seen):
            tracks[i].append((number, float(pixels[i, 0]), float(pixels[i, 1])))
    kept = np.array([len(track) >= 2 for track in tracks], dtype=bool)
    noisy = xyz + NOISE * random.standard_normal(xyz.shape)
    return Points(noisy[kept], rgb[kept], [track for track in tracks if len(track) >= 2])


def _draw(view: View, count: int, random: np.random.Generator) -> tuple[Array, NDArray[np.uint8]]:
    """World positions and colours of random pixels that show a surface."""
    candidates = np.flatnonzero(((view.depth > 0) & view.is_usable).ravel())
    chosen = random.choice(candidates, min(count, len(candidates)), replace=False)
    rays = pixel_rays(view.camera).numpy().reshape(-1, 3)[chosen].astype(np.float64)
    local = rays * view.depth.reshape(-1, 1)[chosen]
    pose = view.camera.cam_from_world.numpy()
    return (local - pose[:3, 3]) @ pose[:3, :3], view.photo.reshape(-1, 3)[chosen]


def _project(view: View, xyz: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Pixel positions ``[N, 2]`` in a view, and whether the point is the surface seen there."""
    pose, (fx, fy, cx, cy) = view.camera.cam_from_world.numpy(), view.camera.intrinsics
    local = xyz @ pose[:3, :3].T + pose[:3, 3]
    z = np.where(local[:, 2] > 0.1, local[:, 2], np.inf)
    pixels = local[:, :2] / z[:, None] * [fx, fy] + [cx, cy]
    column, row = np.floor(pixels).astype(np.int64).T
    height, width = view.depth.shape
    is_inside = (column >= 0) & (column < width) & (row >= 0) & (row < height) & np.isfinite(z)
    row, column = np.where(is_inside, row, 0), np.where(is_inside, column, 0)
    seen = view.depth[row, column]
    is_same = np.abs(seen - local[:, 2]) < DEPTH_TOLERANCE * local[:, 2]
    return pixels, is_inside & is_same & view.is_usable[row, column]
