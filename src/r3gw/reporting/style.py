"""The look of all figures, and how they are saved: same data, same bytes."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import matplotlib.style
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler
from numpy.typing import NDArray

from r3gw.files import atomic_path

# Okabe and Ito (2008): told apart by colour-blind readers too.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DPI = 200
MARGIN_IN = 0.3
_LOOK = {
    "font.family": "DejaVu Sans",
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e5e5e5",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "axes.prop_cycle": cycler(color=COLOURS),
    "pdf.fonttype": 42,
}


@dataclass(frozen=True)
class Cell:
    """One picture of a grid, ``[H, W, 3]`` uint8, with a label in its corner."""

    picture: NDArray[np.uint8]
    label: str = ""


@contextmanager
def look() -> Iterator[None]:
    """Apply the common style to figures made inside."""
    with matplotlib.style.context(_LOOK):
        yield


def new_figure(width_in: float, height_in: float) -> Figure:
    """An empty figure that needs no display."""
    figure = Figure(figsize=(width_in, height_in))
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, target: Path, *, as_pdf: bool) -> None:
    """Write ``target`` (.png) and, for plots, the same name as .pdf; no dates inside."""
    with atomic_path(target) as path:
        figure.savefig(path, dpi=DPI, metadata={"Software": None})
    if as_pdf:
        with atomic_path(target.with_suffix(".pdf")) as path:
            figure.savefig(path, metadata={"CreationDate": None, "Producer": None})


def picture_grid(
    rows: Sequence[Sequence[Cell | None]],
    column_titles: Sequence[str],
    row_titles: Sequence[str],
    *,
    cell_width_in: float = 1.7,
) -> Figure:
    """Pictures in an aligned grid, titles above the columns and left of the rows.

    Args:
        rows: Cells, all rows of the same length; None stays empty.
        column_titles: One per column.
        row_titles: One per row.
        cell_width_in: Width of a cell; its height follows the row's first picture.
    """
    gap = 0.04
    heights = [cell_width_in * _aspect(row) for row in rows]
    width = MARGIN_IN + len(column_titles) * (cell_width_in + gap)
    height = MARGIN_IN + sum(heights) + gap * len(rows)
    figure = new_figure(width, height)
    top = height - MARGIN_IN
    for row, row_title, row_height in zip(rows, row_titles, heights, strict=True):
        bottom = top - row_height
        for column, cell in enumerate(row):
            left = MARGIN_IN + column * (cell_width_in + gap)
            if cell is not None:
                box = (left / width, bottom / height, cell_width_in / width, row_height / height)
                _draw(figure, cell, box)
        middle = (bottom + top) / 2 / height
        figure.text(0.12 / width, middle, row_title, rotation=90, ha="center", va="center", size=6)
        top = bottom - gap
    for column, title in enumerate(column_titles):
        left = MARGIN_IN + column * (cell_width_in + gap) + cell_width_in / 2
        figure.text(
            left / width, 1 - 0.16 / height, title, ha="center", va="center", linespacing=0.95
        )
    return figure


def _aspect(row: Sequence[Cell | None]) -> float:
    pictures = [cell.picture for cell in row if cell is not None]
    return pictures[0].shape[0] / pictures[0].shape[1] if pictures else 0.0


def _draw(figure: Figure, cell: Cell, box: tuple[float, float, float, float]) -> None:
    axes = figure.add_axes(box)
    axes.imshow(cell.picture, interpolation="lanczos")
    axes.set_axis_off()
    if cell.label:
        axes.text(
            *(0.025, 0.04, cell.label),
            transform=axes.transAxes,
            color="white",
            size=6.5,
            bbox={"facecolor": "black", "alpha": 0.6, "pad": 1.5, "linewidth": 0},
        )
