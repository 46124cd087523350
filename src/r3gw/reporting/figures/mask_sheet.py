"""The contact sheets of a scene's masks: every photo with sky and occluders tinted."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from r3gw.imaging.files import read_rgb
from r3gw.masks.folder import load_masks
from r3gw.masks.found import load_found
from r3gw.reporting.figures.style import Cell, in_rows, look, picture_grid, save
from r3gw.scene import View, load_scene
from r3gw.scene.selection import evenly

TILE_PX = (320, 240)
PER_ROW = 4
MOST_PHOTOS = 60
SKY_TINT = np.array([255.0, 0.0, 140.0])
OCCLUDER_TINT = np.array([255.0, 200.0, 0.0])
TINT_SHARE = 0.5

Rgb = NDArray[np.uint8]
Mask = NDArray[np.bool_]


def mask_sheet(scene: str, scene_folder: Path, masks_folder: Path, target: Path) -> None:
    """Draw ``target/<scene>_masks.png``.

    Args:
        scene: Name of the scene, the beginning of the file's name.
        scene_folder: Imported scene.
        masks_folder: Result of the mask stage.
        target: Folder of figures.

    Raises:
        InputError: If a photo or mask is missing or of the wrong size.
    """
    views = load_scene(scene_folder).views
    with look():
        figure = _sheet(views, scene_folder, masks_folder, None)
        save(figure, target / f"{scene}_masks.png", as_pdf=False)


def occluder_sheet(scene_folder: Path, masks_folder: Path, run: Path) -> Figure | None:
    """The training photos with the occluders that a run found beside the masks' own.

    Args:
        scene_folder: Imported scene.
        masks_folder: Result of the mask stage.
        run: Folder of the run.

    Returns:
        None where the run looked for none.
    """
    views = load_scene(scene_folder).split("train")
    if all(load_found(run, view) is None for view in views):
        return None
    return _sheet(views, scene_folder, masks_folder, run)


def _sheet(
    views: Sequence[View], scene_folder: Path, masks_folder: Path, run: Path | None
) -> Figure:
    chosen = evenly(views, MOST_PHOTOS)
    cells = [
        Cell(_tile(view, scene_folder, masks_folder, run), f"{view.name} ({view.split})")
        for view in chosen
    ]
    rows = in_rows(cells, PER_ROW)
    counted = f"{len(chosen)} of {len(views)} photos"
    titles = ["pink: sky", "yellow: occluder, not used", "plain: foreground", counted]
    return picture_grid(rows, titles, [""] * len(rows))


def overlay(photo: Rgb, is_valid: Mask, is_sky: Mask) -> Rgb:
    """The photo ``[H, W, 3]`` with sky and, above it, occluders tinted."""
    tinted = photo.astype(np.float64)
    for mask, tint in ((is_sky, SKY_TINT), (~is_valid, OCCLUDER_TINT)):
        tinted[mask] = (1.0 - TINT_SHARE) * photo[mask] + TINT_SHARE * tint
    return np.asarray(np.round(tinted), np.uint8)


def _tile(view: View, scene_folder: Path, masks_folder: Path, run: Path | None) -> Rgb:
    is_valid, is_sky = load_masks(masks_folder, view)
    found = None if run is None else load_found(run, view)
    if found is not None:
        is_valid = is_valid & ~found
    picture = overlay(read_rgb(scene_folder / view.image), is_valid, is_sky)
    factor = min(TILE_PX[0] / view.width, TILE_PX[1] / view.height)
    width, height = max(1, round(view.width * factor)), max(1, round(view.height * factor))
    filter_ = cv2.INTER_AREA if factor < 1.0 else cv2.INTER_CUBIC
    tile = np.full((TILE_PX[1], TILE_PX[0], 3), 255, np.uint8)
    left, top = (TILE_PX[0] - width) // 2, (TILE_PX[1] - height) // 2
    scaled = cv2.resize(picture, (width, height), interpolation=filter_)
    tile[top : top + height, left : left + width] = scaled
    return tile
