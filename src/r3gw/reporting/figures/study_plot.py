"""The figure of a study: PSNR over the seconds of a training."""

from pathlib import Path

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from r3gw.reporting.figures.plots import DASHES
from r3gw.reporting.figures.style import COLOURS, look, new_figure, save
from r3gw.reporting.tables.study import FIGURES

MARKERS = "osD^vPX<>p"
LEGEND_LINES = 18


def study_figure(table: pd.DataFrame, baseline: str, target: Path) -> None:
    """Draw ``target`` (.png) and the same as .pdf.

    Args:
        table: What `r3gw.reporting.tables.study.study_table` returns.
        baseline: The variant through which dashed lines go: above and left of it is better.
        target: results/figures/study.png.
    """
    with look():
        save(_figure(table, baseline), target, as_pdf=True)


def _figure(table: pd.DataFrame, baseline: str) -> Figure:
    """One panel per way to score test views; of training views if there are no others."""
    scored = [name for name in ("psnr_exact", "psnr") if f"{name}_avg" in table]
    names = scored or ["psnr_learned"]
    columns = -(-len(table) // LEGEND_LINES)
    width, legend_width = 2.9 * len(names), 1.7 * columns
    figure = new_figure(width + legend_width, 3.2)
    for number, name in enumerate(names, start=1):
        _draw(figure.add_subplot(1, len(names), number), table, name, baseline)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="center right", ncols=columns, fontsize=6)
    figure.tight_layout(rect=(0, 0, width / (width + legend_width), 1))
    return figure


def _draw(axes: Axes, table: pd.DataFrame, figure: str, baseline: str) -> None:
    seconds, means = table["training_seconds_mean"], table[f"{figure}_avg"]
    spreads = table[f"{figure}_std_avg"].fillna(0.0)
    for number, variant in enumerate(table["variant"]):
        is_baseline = variant == baseline
        axes.errorbar(
            seconds[number],
            means[number],
            yerr=spreads[number],
            fmt="*" if is_baseline else MARKERS[number // (len(COLOURS) - 1) % len(MARKERS)],
            color=COLOURS[-1] if is_baseline else COLOURS[number % (len(COLOURS) - 1)],
            markersize=8 if is_baseline else 4,
            elinewidth=0.5,
            label=variant.replace("_", " "),
        )
        if is_baseline:
            axes.axhline(means[number], color="grey", linestyle=DASHES, linewidth=0.6)
            axes.axvline(seconds[number], color="grey", linestyle=DASHES, linewidth=0.6)
    axes.set_xlabel("training (s)")
    axes.set_ylabel(f"{FIGURES[figure][0]} (dB)")
