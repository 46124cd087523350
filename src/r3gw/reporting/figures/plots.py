"""Figures made of curves: training and sun sweep."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from r3gw.reporting.figures.evaluated import Evaluated
from r3gw.reporting.figures.style import COLOURS, new_figure

SMOOTHED_ROWS = 15
CIRCLE_COLOUR = "#9aa5ad"
DASHES = (0, (3, 1.5))


def training_plot(runs: Sequence[Evaluated]) -> Figure:
    """Loss, PSNR of the drawn photo, and Gaussian counts over the iterations."""
    figure = new_figure(7.2, 2.3)
    loss, psnr, count = (figure.add_subplot(1, 3, i) for i in (1, 2, 3))
    for run, colour in zip(runs, _colours(len(runs)), strict=True):
        at = run.history["iteration"]
        for axes, column in ((loss, "loss"), (psnr, "psnr")):
            axes.plot(at, run.history[column], color=colour, alpha=0.2, linewidth=0.6)
            axes.plot(at, _smooth(run.history[column]), color=colour, label=run.label)
        count.plot(at, run.history["num_foreground"] / 1000, color=colour)
        count.plot(at, run.history["num_sky"] / 1000, color=colour, linestyle=DASHES)
    _name(loss, "loss")
    loss.set_ylim(bottom=0.0)
    _name(psnr, "training PSNR (dB)")
    _name(count, "Gaussians (thousands)")
    count.plot([], [], color="grey", label="foreground")
    count.plot([], [], color="grey", linestyle=DASHES, label="sky")
    count.legend(fontsize=6)
    psnr.legend(fontsize=6)
    figure.tight_layout()
    return figure


def sweep_plot(run: Evaluated) -> Figure:
    """PSNR over the sun angle of the sweeping protocols, one panel per test view.

    The dot is the oracle's choice; the dashed line is the PSNR under the true light, if known.
    """
    swept = [view for view, protocol in run.records if protocol == "nerf-osr"]
    columns = min(4, len(swept))
    lines = -(-len(swept) // columns)
    figure = new_figure(1.9 * columns, 1.7 * lines + 0.3)
    for number, view in enumerate(swept):
        record = run.records[view, "nerf-osr"]
        axes = figure.add_subplot(lines, columns, number + 1)
        angles_deg = np.degrees(record["sweep_angles_rad"])
        best_deg = np.degrees(record["angle_rad"])
        if (view, "full-yaw") in run.records:
            circle = run.records[view, "full-yaw"]
            at = np.degrees(circle["sweep_angles_rad"])
            axes.plot(at, circle["sweep_psnr"], color=CIRCLE_COLOUR, label="full-yaw sweep")
        axes.plot(angles_deg, record["sweep_psnr"], color=COLOURS[0], label="nerf-osr sweep")
        axes.plot(best_deg, record["psnr"], "o", color=COLOURS[1], ms=4, label="oracle's choice")
        if (view, "exact") in run.records:
            exact = run.records[view, "exact"]["psnr"]
            axes.axhline(exact, color=COLOURS[2], linestyle=DASHES, label="true light")
        axes.set_title(view, size=6)
        axes.set_xlabel("sun angle (degrees)")
        if number % columns == 0:
            axes.set_ylabel("masked PSNR (dB)")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncols=len(labels), fontsize=6)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.2 / figure.get_figheight()))
    return figure


def _smooth(values: pd.Series) -> pd.Series:
    return values.rolling(SMOOTHED_ROWS, min_periods=1, center=True).mean()


def _colours(count: int) -> list[str]:
    return [COLOURS[i % len(COLOURS)] for i in range(count)]


def _name(axes: Axes, title: str) -> None:
    axes.set_xlabel("iteration")
    axes.set_title(title)
