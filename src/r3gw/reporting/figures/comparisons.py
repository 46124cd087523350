"""Figures that hold variants and truth side by side: depth, sky boundary, albedo and normals."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Bool
from matplotlib.figure import Figure
from numpy.typing import NDArray

from r3gw.evaluation.decomposition import scale_per_channel, sky_band
from r3gw.evaluation.evaluated_scene import scored_pixels
from r3gw.imaging.colour import GAMMA, display_array_from_linear
from r3gw.imaging.files import read_linear, read_rgb
from r3gw.imaging.pictures import bytes_from_display, normal_picture
from r3gw.masks.folder import load_masks
from r3gw.reporting.figures.style import Cell, Scale, picture_grid
from r3gw.reporting.figures.truth import depth_scale
from r3gw.reporting.runs import Run
from r3gw.scene import Scene, View

NUM_ROWS = 3
CROP_SHARE = 0.28  # of the picture's width and height
ANGLE_ERROR = Scale("magma", 0.0, 60.0, "angular error (degrees)")
DEPTH_ERROR = Scale("magma", 0.0, 0.25, "relative depth error")
CENTRED = 0.8  # how much a window at the side counts less than one in the middle

Row = list[Cell | None]


def depth_figure(scene: Scene, scene_folder: Path, runs: Sequence[Run]) -> Figure:
    """Depth of every variant on one scale; truth and the first variant's error where known."""
    views = runs[0].shown_views(scene)[:NUM_ROWS]
    truths = {view.name: _true(scene_folder, view, "depth") for view in views}
    known = [truths[view.name] for view in views]
    shown = [
        t[..., 0] if t is not None else runs[0].depth(view.name)
        for view, t in zip(views, known, strict=True)
    ]
    scale = depth_scale(shown)
    rows = []
    for view in views:
        row: Row = [Cell(read_rgb(scene_folder / view.image))]
        row += [_depth_cell(scale, run.depth(view.name)) for run in runs]
        truth = truths[view.name]
        if truth is not None:
            row += _depth_truth(scale, runs[0].depth(view.name), truth[..., 0])
        rows.append(row)
    has_truth = any(truth is not None for truth in truths.values())
    titles = ["photo", *(run.label for run in runs)]
    titles += ["truth", f"error of\n{runs[0].label}"] if has_truth else []
    rows = [row + [None] * (len(titles) - len(row)) for row in rows]
    scales = [scale, DEPTH_ERROR] if has_truth else [scale]
    return picture_grid(rows, titles, [view.name for view in views], scales=scales)


def sky_boundary_figure(
    scene: Scene, scene_folder: Path, masks_folder: Path, runs: Sequence[Run]
) -> Figure:
    """Training photos with a window on the sky's outline, enlarged for photo and variants.

    Labels are the PSNR within 5 px of the outline, over the whole picture.
    """
    rows, names = [], []
    for view in scene.split("train"):
        pictures = [run.picture(view.name, "learned") for run in runs]
        is_valid, is_sky = load_masks(masks_folder, view)
        band = sky_band(is_sky) & is_valid
        if any(picture is None for picture in pictures) or not band.any():
            continue
        frame = busiest_window(band)
        photo = read_rgb(scene_folder / view.image)
        row: Row = [Cell(photo, frame_px=frame), Cell(_crop(photo, frame))]
        for run, picture in zip(runs, pictures, strict=True):
            psnr = run.boundary_psnr(view.name)
            label = "" if psnr is None else f"{psnr:.2f} dB"
            row.append(None if picture is None else Cell(_crop(picture, frame), label))
        rows.append(row)
        names.append(view.name)
    titles = ["photo", "photo, enlarged", *(run.label for run in runs)]
    return picture_grid(rows[:NUM_ROWS], titles, names[:NUM_ROWS])


def surfaces_figure(scene: Scene, scene_folder: Path, run: Run) -> Figure:
    """Albedo and normals beside the truth, albedo after one factor per channel for the figure."""
    views = run.shown_views(scene)[:NUM_ROWS]
    truths = {view.name: _true(scene_folder, view, "albedo") for view in views}
    known = [view for view in views if truths[view.name] is not None]
    factors = _albedo_factors(scene_folder, known, run)
    rows = []
    for view in views:
        albedo, normal = (run.picture(view.name, kind) for kind in ("albedo", "normal"))
        if albedo is None or normal is None:
            continue
        is_surface = run.depth(view.name) > 0
        linear = np.where(is_surface[..., None], (albedo / 255.0) ** GAMMA * factors, 1.0)
        shown = Cell(bytes_from_display(display_array_from_linear(linear)))
        row: Row = [Cell(read_rgb(scene_folder / view.image)), shown]
        if known:
            row += _surface_truth(scene_folder, view, normal)
        else:
            row.append(Cell(normal))
        rows.append(row)
    titles = ["photo", "albedo", "normals"]
    if known:
        titles = ["photo", "albedo", "true albedo", "normals", "true normals", "normals' error"]
    rows = [row + [None] * (len(titles) - len(row)) for row in rows]
    scales = [ANGLE_ERROR] if known else []
    return picture_grid(rows, titles, [view.name for view in views], scales=scales)


def busiest_window(band: Bool[np.ndarray, "h w"]) -> tuple[int, int, int, int]:
    """``(left, top, width, height)`` in pixels of the window that holds most of a mask.

    Pixels count less towards the sides, where trees are, than in the middle, where buildings are.
    """
    height, width = band.shape
    rows, columns = max(int(height * CROP_SHARE), 1), max(int(width * CROP_SHARE), 1)
    to_side = np.abs(2 * (np.arange(width) + 0.5) / width - 1)
    sums = cv2.integral(band * (1 - CENTRED * to_side))
    inside = sums[rows:, columns:] - sums[:-rows, columns:] - sums[rows:, :-columns]
    inside = inside + sums[:-rows, :-columns]
    top, left = np.unravel_index(int(inside.argmax()), inside.shape)
    return int(left), int(top), columns, rows


def _true(scene_folder: Path, view: View, kind: str) -> NDArray[np.float32] | None:
    return None if view.truth is None else read_linear(scene_folder / getattr(view.truth, kind))


def _depth_cell(scale: Scale, depth: NDArray[np.floating]) -> Cell:
    return Cell(scale.coloured(depth, depth > 0))


def _depth_truth(
    scale: Scale, ours: NDArray[np.floating], truth: NDArray[np.floating]
) -> list[Cell]:
    is_known = (truth > 0) & (ours > 0)
    error = np.abs(ours - truth) / np.where(truth > 0, truth, 1.0)
    return [_depth_cell(scale, truth), Cell(DEPTH_ERROR.coloured(error, is_known))]


def _albedo_factors(scene_folder: Path, views: Sequence[View], run: Run) -> NDArray[np.floating]:
    """Least-squares factor per channel from our albedo to the true one; 1 without truth."""
    ours, true = [], []
    for view in views:
        albedo, truth = run.picture(view.name, "albedo"), _true(scene_folder, view, "albedo")
        if albedo is not None and truth is not None:
            where = scored_pixels(scene_folder, view) & (run.depth(view.name) > 0)
            ours.append((albedo[where] / 255.0) ** GAMMA)
            true.append(truth[where].astype(np.float64))
    return scale_per_channel(np.concatenate(ours), np.concatenate(true)) if ours else np.ones(3)


def _surface_truth(scene_folder: Path, view: View, normal: NDArray[np.uint8]) -> Row:
    """True albedo, our normals, true normals, and the angle between the latter two."""
    albedo, truth = (_true(scene_folder, view, kind) for kind in ("albedo", "normal"))
    if albedo is None or truth is None:
        return [None, Cell(normal)]
    is_surface = np.linalg.norm(truth, axis=-1) > 0.5
    shown = np.where(is_surface[..., None], display_array_from_linear(albedo), 1.0)
    ours = normal / 127.5 - 1.0
    length = np.linalg.norm(ours, axis=-1)
    true = 2 * (normal_picture(truth) / 255.0) - 1.0
    cosine = (ours * true).sum(axis=-1) / np.maximum(length * np.linalg.norm(true, axis=-1), 1e-9)
    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return [
        Cell(bytes_from_display(shown)),
        Cell(normal),
        Cell(normal_picture(truth)),
        Cell(ANGLE_ERROR.coloured(angle, is_surface & (length > 0.5))),
    ]


def _crop(picture: NDArray[np.uint8], frame: tuple[int, int, int, int]) -> NDArray[np.uint8]:
    left, top, width, height = frame
    return picture[top : top + height, left : left + width]
