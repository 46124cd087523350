"""Plots of a scene's points in space: what training begins with, and what SfM found."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from r3gw.evaluation.gallery import evenly
from r3gw.gaussians.initial import load_initial
from r3gw.reporting.style import COLOURS, new_figure
from r3gw.scene import Points, Scene

MAX_POINTS = 6000
SKY_COLOUR = "#56B4E9"
Split = Literal["train", "test"]


SIDES = {"from the side": (-60.0, 18.0), "from above": (-90.0, 89.9)}  # azimuth, elevation
CAMERA_COLOURS = {"train": COLOURS[1], "test": COLOURS[3]}
SHOWN_QUANTILES = (0.01, 0.99)  # of the points, per axis: stray points would shrink the rest


def initial_figure(scene: Scene, points: Points, initial_file: Path) -> Figure:
    """The initial point sets: SfM points in their colours, the sky's in blue; and the cameras."""
    sky = load_initial(initial_file).sky_points().numpy()
    return _two_sides(scene, points, sky, ("train",))


def sfm_figure(scene: Scene, points: Points) -> Figure:
    """The SfM points in their colours and the cameras of both splits."""
    return _two_sides(scene, points, np.zeros((0, 3)), ("train", "test"))


def _two_sides(
    scene: Scene, points: Points, sky: Float[np.ndarray, "m 3"], splits: Sequence[Split]
) -> Figure:
    low, high = np.quantile(points.xyz, SHOWN_QUANTILES, axis=0)
    is_shown = ((points.xyz >= low) & (points.xyz <= high)).all(axis=1)
    chosen = np.array(evenly(np.flatnonzero(is_shown).tolist(), MAX_POINTS), np.int64)
    xyz, colours = points.xyz[chosen], points.rgb[chosen] / 255.0
    figure = new_figure(6.6, 3.2)
    for number, (title, (azimuth, elevation)) in enumerate(SIDES.items()):
        axes = figure.add_axes((0.5 * number, 0.0, 0.5, 0.92), projection="3d")
        assert isinstance(axes, Axes3D)
        axes.set_title(title)
        shown = [xyz]
        if len(sky):
            _scatter(axes, sky, SKY_COLOUR, 0.8, f"sky, {len(sky):,} Gaussians")
            shown.append(sky)
        kind = f"SfM, {len(points.xyz):,} points"
        _scatter(axes, xyz, colours, 0.8, kind)
        for split in splits:
            if views := scene.split(split):
                centres = np.stack([view.camera.centre.double().numpy() for view in views])
                kind = f"{split} cameras, {len(views)}"
                _scatter(axes, centres, CAMERA_COLOURS[split], 14.0, kind, marker="^")
                shown.append(centres)
        _frame(axes, np.concatenate(shown), azimuth, elevation)
        if number == 0:
            axes.legend(loc="lower left", fontsize=6, markerscale=1.5)
    return figure


def _scatter(
    axes: Axes3D,
    xyz: Float[np.ndarray, "n 3"],
    colours: str | NDArray[np.floating],
    size: float,
    label: str,
    marker: str = "o",
) -> None:
    """Points in plot axes: world x, z, and up (-y) upwards."""
    axes.scatter(
        *(xyz[:, 0], xyz[:, 2], -xyz[:, 1]),
        s=size, c=colours, marker=marker, label=label, linewidths=0, rasterized=True,
        depthshade=False,
    )  # fmt: skip


def _frame(
    axes: Axes3D, xyz: Float[np.ndarray, "n 3"], azimuth_deg: float, elevation_deg: float
) -> None:
    """The same scale on all axes, just around the points."""
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[2], high[2])
    axes.set_zlim(-high[1], -low[1])
    size = high - low
    axes.set_box_aspect((size[0], size[2], size[1]), zoom=1.15)
    axes.view_init(elevation_deg, azimuth_deg)
    axes.set_proj_type("ortho")
    axes.tick_params(labelsize=5, pad=-3)
    axes.locator_params(nbins=4)
    axes.set(xlabel="x", ylabel="z", zlabel="up (-y)" if elevation_deg < 45 else "")
    if elevation_deg > 45:
        axes.set_zticks([])
