"""Figures of a scene under other lights: a turning map, learned lights, one light for two views."""

from matplotlib.figure import Figure

from r3gw.reporting.figures.style import Cell, picture_grid
from r3gw.reporting.runs import Run
from r3gw.scene.selection import evenly

NUM_TURNS = 4
NUM_LIGHTS = 4
NUM_SHARED = 3


def turned_figure(run: Run) -> Figure:
    """Views under one map at several turns about the vertical, the map in the corner."""
    relit = run.relit
    step = len(relit.yaws_deg) // NUM_TURNS
    yaws = relit.yaws_deg[::step]
    rows = [
        [Cell(relit.turned(view, yaw), thumbnail=relit.turned_map(yaw)) for yaw in yaws]
        for view in relit.views
    ]
    titles = [f"{relit.map_name}, {yaw}°" if yaw == 0 else f"turned by {yaw}°" for yaw in yaws]
    return picture_grid(rows, titles, list(relit.views))


def learned_figure(run: Run) -> Figure:
    """Views under lights learned for training photos, the lights in the corner."""
    relit = run.relit
    numbers = evenly(range(len(relit.photos)), NUM_LIGHTS)
    rows = [
        [Cell(relit.learned(view, n), thumbnail=relit.learned_map(n)) for n in numbers]
        for view in relit.views
    ]
    titles = [f"light of\n{relit.photos[n]}" for n in numbers]
    return picture_grid(rows, titles, list(relit.views))


def shared_light_figure(run: Run) -> Figure:
    """The same learned light and sky from two viewpoints: reflections follow the eye."""
    relit = run.relit
    numbers = evenly(range(len(relit.photos)), NUM_SHARED)
    rows = [
        [
            Cell(relit.learned(view, n), thumbnail=relit.learned_map(n) if i == 0 else None)
            for i, view in enumerate(relit.views)
        ]
        for n in numbers
    ]
    titles = [f"viewpoint {i + 1}" for i in range(len(relit.views))]
    return picture_grid(rows, titles, [relit.photos[n] for n in numbers], cell_width_in=2.6)
