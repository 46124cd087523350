"""Figures made of curves: training and sun sweep."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from r3gw.reporting.evaluated import Evaluated
from r3gw.reporting.style import COLOURS, new_figure

SMOOTHED_ROWS = 15


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
        count.plot(at, run.history["num_sky"] / 1000, color=colour, linestyle=(0, (3, 1.5)))
    _name(loss, "loss", log=True)
    _name(psnr, "training PSNR (dB)")
    _name(count, "Gaussians (thousands)")
    count.plot([], [], color="grey", label="foreground")
    count.plot([], [], color="grey", linestyle=(0, (3, 1.5)), label="sky")
    count.legend(fontsize=6)
    psnr.legend(fontsize=6)
    figure.tight_layout()
    return figure


def sweep_plot(run: Evaluated) -> Figure:
    """PSNR over the sun angle of protocol nerf-osr, one panel per test view.

    The dot is the oracle's choice; the dashed line is the PSNR under the true light.
    """
    swept = [view for view, protocol in run.records if protocol == "nerf-osr"]
    columns = min(4, len(swept))
    lines = -(-len(swept) // columns)
    figure = new_figure(1.9 * columns, 1.7 * lines + 0.2)
    for number, view in enumerate(swept):
        record = run.records[view, "nerf-osr"]
        axes = figure.add_subplot(lines, columns, number + 1)
        axes.plot(np.degrees(record["sweep_angles_rad"]), record["sweep_psnr"], color=COLOURS[0])
        axes.plot(np.degrees(record["angle_rad"]), record["psnr"], "o", color=COLOURS[1], ms=4)
        if (view, "exact") in run.records:
            exact = run.records[view, "exact"]["psnr"]
            axes.axhline(exact, color=COLOURS[2], linestyle=(0, (3, 1.5)))
        axes.set_title(view, size=6)
        axes.set_xlabel("sun angle (degrees)")
        if number % columns == 0:
            axes.set_ylabel("masked PSNR (dB)")
    figure.tight_layout()
    return figure


def _smooth(values: pd.Series) -> pd.Series:
    return values.rolling(SMOOTHED_ROWS, min_periods=1, center=True).mean()


def _colours(count: int) -> list[str]:
    return [COLOURS[i % len(COLOURS)] for i in range(count)]


def _name(axes: Axes, title: str, *, log: bool = False) -> None:
    axes.set_xlabel("iteration")
    axes.set_title(title)
    if log:
        axes.set_yscale("log")
