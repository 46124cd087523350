"""The look of all figures, and how they are saved: same data, same bytes."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import matplotlib.style
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.rcsetup import cycler
from numpy.typing import NDArray

from r3gw.files import atomic_path
from r3gw.imaging.pictures import bytes_from_display

# Okabe and Ito (2008): told apart by colour-blind readers too.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DPI = 200
MARGIN_IN = 0.3
PNG_LEVEL = 4  # a third of the time of the default, a tenth more bytes
BAR_IN = 0.55  # of a grid's width, for colour bars
UNKNOWN = 0.87
ACCENT = "#e6007e"  # frames on photos: a colour that no building has
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
    "svg.hashsalt": "r3gw",
}


@dataclass(frozen=True)
class Cell:
    """One picture of a grid.

    Attributes:
        picture: ``[H, W, 3]`` uint8.
        label: Text in the lower left corner.
        thumbnail: Small picture in the upper left corner, such as an environment map.
        frame_px: ``(left, top, width, height)`` of a frame drawn on the picture.
    """

    picture: NDArray[np.uint8]
    label: str = ""
    thumbnail: NDArray[np.uint8] | None = None
    frame_px: tuple[int, int, int, int] | None = None


@dataclass(frozen=True)
class Scale:
    """A colour map with its ends, drawn as a bar beside a grid.

    Attributes:
        colours: Name of a matplotlib colour map.
        low, high: Values at its ends; what lies beyond takes the end's colour.
        title: What the values are, with units.
    """

    colours: str
    low: float
    high: float
    title: str

    def coloured(
        self, values: NDArray[np.floating], is_known: NDArray[np.bool_]
    ) -> NDArray[np.uint8]:
        """Values ``[H, W]`` as a picture; what is not known is light grey."""
        share = np.clip((values - self.low) / max(self.high - self.low, 1e-9), 0.0, 1.0)
        picture = matplotlib.colormaps[self.colours](share)[..., :3]
        return bytes_from_display(np.where(is_known[..., None], picture, UNKNOWN))


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
        options = {"compress_level": PNG_LEVEL}
        figure.savefig(path, dpi=DPI, metadata={"Software": None}, pil_kwargs=options)
    if as_pdf:
        with atomic_path(target.with_suffix(".pdf")) as path:
            figure.savefig(path, metadata={"CreationDate": None, "Producer": None})


def in_rows(cells: Sequence[Cell], per_row: int) -> list[list[Cell | None]]:
    """Cells in rows of one length; the last row ends with empty places."""
    rows: list[list[Cell | None]] = []
    for start in range(0, len(cells), per_row):
        row = cells[start : start + per_row]
        rows.append([*row, *[None] * (per_row - len(row))])
    return rows


def picture_grid(
    rows: Sequence[Sequence[Cell | None]],
    column_titles: Sequence[str],
    row_titles: Sequence[str],
    *,
    cell_width_in: float = 1.7,
    scales: Sequence[Scale] = (),
) -> Figure:
    """Pictures in an aligned grid, titles above the columns and left of the rows.

    Args:
        rows: Cells, all rows of the same length; None stays empty.
        column_titles: A title per column.
        row_titles: A title per row.
        cell_width_in: Width of a cell; its height follows the row's first picture.
        scales: Colour bars at the right, one above the other.
    """
    gap = 0.04
    heights = [cell_width_in * _aspect(row) for row in rows]
    grid_width = MARGIN_IN + len(column_titles) * (cell_width_in + gap)
    width = grid_width + (BAR_IN if scales else 0.0)
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
    _draw_bars(figure, scales, grid_width, sum(heights) + gap * (len(rows) - 1))
    return figure


def _draw_bars(
    figure: Figure, scales: Sequence[Scale], left_in: float, pictures_height_in: float
) -> None:
    """Colour bars right of the pictures, sharing their height."""
    width, height = figure.get_size_inches()
    each = pictures_height_in / max(len(scales), 1)
    for number, scale in enumerate(scales):
        bottom = height - MARGIN_IN - (number + 1) * each + 0.05 * each
        axes = figure.add_axes(
            (left_in / width, bottom / height, 0.09 / width, 0.9 * each / height)
        )
        mappable = ScalarMappable(Normalize(scale.low, scale.high), scale.colours)
        bar = figure.colorbar(mappable, cax=axes)
        bar.outline.set_linewidth(0.4)
        bar.ax.tick_params(labelsize=6, width=0.4, length=2)
        bar.set_label(scale.title, size=6.5)


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
    if cell.frame_px is not None:
        left_px, top_px, width_px, height_px = cell.frame_px
        corner = (left_px - 0.5, top_px - 0.5)
        axes.add_patch(
            Rectangle(corner, width_px, height_px, fill=False, edgecolor=ACCENT, linewidth=1.0)
        )
    if cell.thumbnail is not None:
        _draw_thumbnail(figure, cell.thumbnail, box)


def _draw_thumbnail(
    figure: Figure, picture: NDArray[np.uint8], box: tuple[float, float, float, float]
) -> None:
    """A small framed picture in the upper left corner of a cell, a third of its width."""
    left, bottom, width, height = box
    inches = figure.get_size_inches()
    own_width = width / 3
    own_height = own_width * inches[0] / inches[1] * picture.shape[0] / picture.shape[1]
    axes = figure.add_axes((left, bottom + height - own_height, own_width, own_height))
    axes.imshow(picture, interpolation="lanczos", aspect="auto")
    axes.set(xticks=[], yticks=[])
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set(visible=True, color="white", linewidth=0.8)
