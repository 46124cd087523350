"""Figures made of curves and points in a plane: training, sun sweep, study."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from r3gw.evaluation.protocols.facts import EXACT, FULL_YAW, NERF_OSR
from r3gw.reporting.figures.style import COLOURS, new_figure
from r3gw.reporting.runs import Run
from r3gw.reporting.tables.study import Compared, compared_figures

SMOOTHED_ROWS = 15
CIRCLE_COLOUR = "#9aa5ad"
DASHES = (0, (3, 1.5))
MARKERS = "osD^vPX<>p"
LEGEND_LINES = 18


def training_plot(runs: Sequence[Run]) -> Figure:
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


def is_swept(run: Run) -> bool:
    """Whether there is a sweep to plot."""
    return any(protocol == NERF_OSR.name for _, protocol in run.records)


def sweep_plot(run: Run) -> Figure:
    """PSNR over the sun angle of the sweeping protocols, one panel per test view.

    The dot is the oracle's choice; the dashed line is the PSNR under the true light, if known.
    """
    swept = [view for view, protocol in run.records if protocol == NERF_OSR.name]
    columns = min(4, len(swept))
    lines = -(-len(swept) // columns)
    figure = new_figure(1.9 * columns, 1.7 * lines + 0.3)
    for number, view in enumerate(swept):
        record = run.records[view, NERF_OSR.name]
        axes = figure.add_subplot(lines, columns, number + 1)
        angles_deg = np.degrees(record["sweep_angles_rad"])
        best_deg = np.degrees(record["angle_rad"])
        if (view, FULL_YAW.name) in run.records:
            circle = run.records[view, FULL_YAW.name]
            at = np.degrees(circle["sweep_angles_rad"])
            axes.plot(at, circle["sweep_psnr"], color=CIRCLE_COLOUR, label="full-yaw sweep")
        axes.plot(angles_deg, record["sweep_psnr"], color=COLOURS[0], label="nerf-osr sweep")
        axes.plot(best_deg, record["psnr"], "o", color=COLOURS[1], ms=4, label="oracle's choice")
        if (view, EXACT.name) in run.records:
            exact = run.records[view, EXACT.name]["psnr"]
            axes.axhline(exact, color=COLOURS[2], linestyle=DASHES, label="true light")
        axes.set_title(view, size=6)
        axes.set_xlabel("sun angle (degrees)")
        if number % columns == 0:
            axes.set_ylabel("masked PSNR (dB)")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncols=len(labels), fontsize=6)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.2 / figure.get_figheight()))
    return figure


def study_plot(table: pd.DataFrame, baseline: str) -> Figure:
    """PSNR over the seconds of a training: a panel per way to score test views.

    Where no test views are scored, training views take their place.

    Args:
        table: What `r3gw.reporting.tables.study.study_table` returns.
        baseline: The variant through which dashed lines go: above and left of it is better.
    """
    known = [each for each in compared_figures() if f"{each.column}_avg" in table and each.has_gain]
    shown = [each for each in known if each.is_test] or known
    columns = -(-len(table) // LEGEND_LINES)
    width, legend_width = 2.9 * len(shown), 1.7 * columns
    figure = new_figure(width + legend_width, 3.2)
    for number, each in enumerate(shown, start=1):
        _draw_variants(figure.add_subplot(1, len(shown), number), table, each, baseline)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="center right", ncols=columns, fontsize=6)
    figure.tight_layout(rect=(0, 0, width / (width + legend_width), 1))
    return figure


def _draw_variants(axes: Axes, table: pd.DataFrame, shown: Compared, baseline: str) -> None:
    seconds, means = table["training_seconds_mean"], table[f"{shown.column}_avg"]
    spreads = table[f"{shown.column}_std_avg"].fillna(0.0)
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
    axes.set_ylabel(f"{shown.heading} (dB)")


def _smooth(values: pd.Series) -> pd.Series:
    return values.rolling(SMOOTHED_ROWS, min_periods=1, center=True).mean()


def _colours(count: int) -> list[str]:
    return [COLOURS[i % len(COLOURS)] for i in range(count)]


def _name(axes: Axes, title: str) -> None:
    axes.set_xlabel("iteration")
    axes.set_title(title)
