"""Figures made of pictures: test views, decomposition, learned lights."""

from collections.abc import Sequence
from math import isqrt
from pathlib import Path

import cv2
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from r3gw.evaluation.evaluated_scene import scored_pixels
from r3gw.evaluation.gallery import light_picture
from r3gw.files import InputError
from r3gw.imaging.colour import display_array_from_linear
from r3gw.imaging.files import read_rgb
from r3gw.imaging.pictures import bytes_from_display
from r3gw.lighting import envmap
from r3gw.lighting.maps import light_of_map
from r3gw.reporting.columns import pictured_protocols
from r3gw.reporting.figures.style import Cell, Scale, in_rows, picture_grid
from r3gw.reporting.figures.truth import depth_pictures, truth_pictures
from r3gw.reporting.runs import Run
from r3gw.scene import Scene, View
from r3gw.scene.selection import evenly

NUM_DECOMPOSED = 2
NUM_LIGHTS = 24
LIGHTS_PER_ROW = 4
LIGHT_MAP_HEIGHT = 64
BRIGHTEST_QUANTILE = 0.98
ERROR = Scale("magma", 0.0, 0.3, "absolute error (display units)")


def view_grid(scene: Scene, scene_folder: Path, runs: Sequence[Run]) -> Figure:
    """Photos beside every variant's renders: test views if there are any, else training views.

    The first run is shown under every protocol and, under its first one, with its error; the
    others under that one alone. Errors are shown where pixels are scored.
    """
    views = runs[0].shown_views(scene)
    titles_by_protocol = {
        each.name: each.light_title
        for each in pictured_protocols()
        if any((view.name, each.name) in runs[0].records for view in views)
    }
    first, *others = titles_by_protocol
    columns = [(runs[0], protocol) for protocol in (first, *others)]
    columns += [(run, first) for run in runs[1:]]
    rows: list[list[Cell | None]] = []
    for view in views:
        cells = [_cell(run.picture(view.name, p), run.psnr(view.name, p)) for run, p in columns]
        photo = read_rgb(scene_folder / view.image)
        render, error = runs[0].picture(view.name, first), None
        if render is not None:
            is_scored = scored_pixels(scene_folder, view)
            error = _cell(ERROR.coloured(absolute_error(render, photo), is_scored))
        shown = Cell(photo, thumbnail=_light_of(scene_folder, view))
        rows.append([shown, cells[0], error, *cells[1:]])
    titles = [f"{run.label}\n{titles_by_protocol[protocol]}" for run, protocol in columns]
    titles = ["photo", titles[0], "its error", *titles[1:]]
    return picture_grid(rows, titles, [view.name for view in views], scales=[ERROR])


def absolute_error(render: NDArray[np.uint8], photo: NDArray[np.uint8]) -> NDArray[np.floating]:
    """Mean absolute difference over the channels, display units: ``[H, W]``."""
    return np.asarray(np.abs(render.astype(np.float64) - photo).mean(axis=-1) / 255.0)


def _light_of(scene_folder: Path, view: View) -> NDArray[np.uint8] | None:
    """The light of a photo as a thumbnail, if it is known."""
    if view.truth is None:
        return None
    return light_picture(envmap.read_env_map(scene_folder / view.truth.env_map))


def decomposition_grid(scene: Scene, scene_folder: Path, run: Run) -> Figure:
    """Render, albedo, normals, depth, sky and foreground alone, light; beneath, what is true."""
    rows: list[list[Cell | None]] = []
    names = []
    for view in run.shown_views(scene)[:NUM_DECOMPOSED]:
        depths = depth_pictures(run.depth(view.name), view.truth, scene_folder)
        protocol = run.protocol_of(view.name)
        kinds = ("albedo", "normal", "", "sky", "foreground")
        depth = Cell(depths.ours, depths.label)
        parts = [_cell(run.picture(view.name, kind)) if kind else depth for kind in kinds]
        light = _cell(_light_drawn_under(scene_folder, run, view))
        rows.append([_cell(run.picture(view.name, protocol), view.name), *parts, light])
        names.append("model")
        photo = Cell(read_rgb(scene_folder / view.image))
        if view.truth is not None:
            true = truth_pictures(view.truth, scene_folder)
            surfaces = [Cell(true["albedo"]), Cell(true["normal"]), _cell(depths.truth)]
            rows.append([photo, *surfaces, None, None, _cell(_light_of(scene_folder, view))])
        else:
            rows.append([photo, *[None] * 6])
        names.append("truth" if view.truth is not None else "photo")
    titles = ["picture", "albedo", "normals", "depth", "sky alone", "foreground alone", "light"]
    return picture_grid(rows, titles, names)


def _light_drawn_under(scene_folder: Path, run: Run, view: View) -> NDArray[np.uint8] | None:
    """The SH light of a view's first picture as a map: learned, or the true map's."""
    if view.name in run.lights:
        light = run.lights[view.name].sh
    elif view.truth is not None and run.lights:
        degree = isqrt(len(next(iter(run.lights.values())).sh)) - 1
        light = light_of_map(envmap.read_env_map(scene_folder / view.truth.env_map), degree)
    else:
        return None
    return light_picture(envmap.draw(light, LIGHT_MAP_HEIGHT))


def light_grid(scene: Scene, scene_folder: Path, run: Run) -> Figure:
    """Training photos with the light learned for each, all at one exposure."""
    views = [view for view in scene.split("train") if view.name in run.lights]
    if not views:
        raise InputError(f"{run.folder / 'lights.json'}: has no light of a training photo")
    chosen = evenly(views, NUM_LIGHTS)
    maps = {
        view.name: envmap.draw(run.lights[view.name].sh, LIGHT_MAP_HEIGHT).numpy()
        for view in chosen
    }
    brightest = float(np.quantile(np.stack(list(maps.values())), BRIGHTEST_QUANTILE))
    cells = []
    for view in chosen:
        cells += [
            Cell(_thumbnail(read_rgb(scene_folder / view.image)), view.session or ""),
            Cell(bytes_from_display(display_array_from_linear(maps[view.name] / brightest))),
        ]
    rows = in_rows(cells, 2 * LIGHTS_PER_ROW)
    titles = ["photo", "learned light"] * LIGHTS_PER_ROW
    return picture_grid(rows, titles, [""] * len(rows), cell_width_in=1.3)


def _cell(picture: NDArray[np.uint8] | None, label: str = "") -> Cell | None:
    return None if picture is None else Cell(picture, label)


def _thumbnail(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Crop the middle to 2:1, as the maps are."""
    height, width = picture.shape[:2]
    rows = min(height, width // 2)
    top = (height - rows) // 2
    cropped = picture[top : top + rows, : 2 * rows]
    return np.asarray(cv2.resize(cropped, (256, 128), interpolation=cv2.INTER_AREA), np.uint8)
