"""Plots of a scene's points in space: what training begins with, and what SfM found."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from r3gw.model.initial import load_initial
from r3gw.reporting.figures.style import COLOURS, new_figure
from r3gw.scene import Points, Scene
from r3gw.scene.selection import evenly

MAX_POINTS = 6000
SKY_COLOUR = "#56B4E9"
Split = Literal["train", "test"]
AZIMUTH_DEG, ELEVATION_DEG = -60.0, 18.0
CAMERA_COLOURS = {"train": COLOURS[1], "test": COLOURS[3]}
SHOWN_QUANTILES = (0.01, 0.99)  # of the points, per axis: stray points would shrink the rest


def initial_figure(scene: Scene, points: Points, initial_file: Path) -> Figure:
    """The initial point sets: SfM points in their colours, the sky's in blue; and the cameras."""
    sky = load_initial(initial_file).sky_points().numpy()
    return _two_sides(scene, points, sky, ("train",))


def sfm_figure(scene: Scene, points: Points) -> Figure:
    """The SfM points in their colours and the cameras of both splits."""
    return _two_sides(scene, points, np.zeros((0, 3)), ("train", "test"))


@dataclass(frozen=True)
class _Set:
    """Points ``[n, 3]`` that share a look."""

    xyz: NDArray[np.floating]
    colours: str | NDArray[np.floating]
    label: str
    size: float = 0.8
    marker: str = "o"


def _two_sides(
    scene: Scene, points: Points, sky: Float[np.ndarray, "m 3"], splits: Sequence[Split]
) -> Figure:
    """The sets from the side, and from above with a scale."""
    low, high = np.quantile(points.xyz, SHOWN_QUANTILES, axis=0)
    is_shown = ((points.xyz >= low) & (points.xyz <= high)).all(axis=1)
    chosen = np.array(evenly(np.flatnonzero(is_shown).tolist(), MAX_POINTS), np.int64)
    sets = [_Set(sky, SKY_COLOUR, f"sky, {len(sky):,} Gaussians")] if len(sky) else []
    label = f"SfM, {len(points.xyz):,} points"
    sets.append(_Set(points.xyz[chosen], points.rgb[chosen] / 255.0, label))
    for split in splits:
        if views := scene.split(split):
            centres = np.stack([view.camera.centre.double().numpy() for view in views])
            label = f"{split} cameras, {len(views)}"
            sets.append(_Set(centres, CAMERA_COLOURS[split], label, 14.0, "^"))
    figure = new_figure(6.6, 3.1)
    side = figure.add_axes((-0.02, 0.06, 0.56, 0.92), projection="3d")
    assert isinstance(side, Axes3D)
    _draw_side(side, sets)
    _draw_above(figure.add_axes((0.59, 0.16, 0.39, 0.8)), sets)
    handles, labels = side.get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower left", ncols=len(sets), fontsize=6.5, markerscale=1.5)
    return figure


def _draw_side(axes: Axes3D, sets: Sequence[_Set]) -> None:
    """In plot axes: world x, z, and up (-y) upwards; the same scale on all, just around them."""
    for each in sets:
        axes.scatter(
            *(each.xyz[:, 0], each.xyz[:, 2], -each.xyz[:, 1]),
            s=each.size, c=each.colours, marker=each.marker, label=each.label, linewidths=0,
            rasterized=True, depthshade=False,
        )  # fmt: skip
    xyz = np.concatenate([each.xyz for each in sets])
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[2], high[2])
    axes.set_zlim(-high[1], -low[1])
    size = high - low
    axes.set_box_aspect((size[0], size[2], size[1]), zoom=1.35)
    axes.view_init(ELEVATION_DEG, AZIMUTH_DEG)
    axes.set_proj_type("ortho")
    axes.set_axis_off()


def _draw_above(axes: Axes, sets: Sequence[_Set]) -> None:
    for each in sets:
        axes.scatter(
            *(each.xyz[:, 0], each.xyz[:, 2]),
            s=each.size, c=each.colours, marker=each.marker, linewidths=0, rasterized=True,
        )  # fmt: skip
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x (world units)", ylabel="z (world units)")
