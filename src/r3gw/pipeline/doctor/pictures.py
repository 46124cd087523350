"""A picture of the up direction: verticals of the estimated world drawn into photos."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from r3gw.geometry.cameras import UP, Camera
from r3gw.imaging.files import read_rgb
from r3gw.reporting.figures.style import Cell, in_rows, look, picture_grid, save
from r3gw.scene import View
from r3gw.scene.selection import evenly

_PHOTOS = 6
_PER_ROW = 3
_TILE_PX = (480, 360)
_ARROW = 0.16  # of the tile's height
_COLOUR = (255, 0, 140)

Rgb = NDArray[np.uint8]


def up_picture(views: Sequence[View], scene_folder: Path, target: Path) -> None:
    """Draw arrows along the world's up into some photos and write them as one picture.

    Args:
        views: Views of the scene, at least one.
        scene_folder: Where their photos are.
        target: PNG to write.

    Raises:
        InputError: If a photo is unreadable.
    """
    chosen = evenly(views, _PHOTOS)
    cells = [
        Cell(_with_arrows(read_rgb(scene_folder / view.image), view.camera), view.name)
        for view in chosen
    ]
    rows = in_rows(cells, _PER_ROW)
    titles = ["arrows: up in the scene's frame", "they must follow the building's verticals", ""]
    with look():
        figure = picture_grid(rows, titles, [""] * len(rows), cell_width_in=2.2)
        save(figure, target, as_pdf=False)


def image_of_up(camera: Camera, x_px: float, y_px: float) -> NDArray[np.float64]:
    """Direction in which up points at a pixel, unit vector ``[2]`` (x right, y down).

    The point that the pixel shows is moved a little along the world's up and projected again; its
    distance does not matter.
    """
    fx, fy, cx, cy = camera.intrinsics
    ray = np.array([(x_px - cx) / fx, (y_px - cy) / fy, 1.0])
    up = (camera.cam_from_world[:3, :3] @ torch.tensor(UP, dtype=torch.float64)).numpy()
    # Derivative of (fx X/Z, fy Y/Z) at the ray, along up.
    shift = np.array([fx * (up[0] - ray[0] * up[2]), fy * (up[1] - ray[1] * up[2])])
    return np.asarray(shift / max(float(np.linalg.norm(shift)), 1e-12))


def _with_arrows(photo: Rgb, camera: Camera) -> Rgb:
    factor = min(_TILE_PX[0] / camera.width, _TILE_PX[1] / camera.height)
    width, height = (max(1, round(side * factor)) for side in (camera.width, camera.height))
    filter_ = cv2.INTER_AREA if factor < 1.0 else cv2.INTER_CUBIC
    tile = cv2.resize(photo, (width, height), interpolation=filter_).astype(np.uint8)
    scaled = camera.scaled(width, height)
    for x in (0.2, 0.5, 0.8):
        for y in (0.35, 0.75):
            start = np.array([x * width, y * height])
            end = start + _ARROW * height * image_of_up(scaled, *start)
            first, last = ([int(value) for value in point] for point in (start, end))
            cv2.arrowedLine(tile, first, last, _COLOUR, 2, cv2.LINE_AA, 0, 0.3)
    canvas = np.full((_TILE_PX[1], _TILE_PX[0], 3), 255, np.uint8)
    left, top = (_TILE_PX[0] - width) // 2, (_TILE_PX[1] - height) // 2
    canvas[top : top + height, left : left + width] = tile
    return canvas
