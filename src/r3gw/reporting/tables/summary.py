"""Averages over seeds and scenes, and their spread.

A scene's figure is the mean over its views, then over seeds; the average is the mean over scenes.
The spread is the sample standard deviation over seeds.
"""

from collections.abc import Sequence
from math import isnan, nan
from statistics import fmean, stdev

from r3gw.reporting.runs import Run

Row = dict[str, str | int | float]


def in_order(names: Sequence[str]) -> list[str]:
    """Each name once, in order of first appearance."""
    return list(dict.fromkeys(names))


def scenes_with(runs: Sequence[Run], figure: str) -> list[str]:
    """Scenes in which at least one run has the figure."""
    return in_order([run.scene for run in runs if figure in run.figures])


def of_variant(runs: Sequence[Run], variant: str) -> list[Run]:
    """The runs of one variant."""
    return [run for run in runs if run.variant == variant]


def num_seeds(runs: Sequence[Run]) -> int:
    """How many seeds runs have."""
    return len({run.seed for run in runs})


def scene_means(runs: Sequence[Run], figure: str, scenes: Sequence[str]) -> Row:
    """``figure_<scene>`` per scene and ``figure_avg``; NaN where a scene lacks runs.

    Args:
        runs: Runs of one variant.
        figure: Name of the figure.
        scenes: Scenes that the average is taken over; all of them must be there for it.
    """
    means = {}
    for scene in scenes:
        values = _values(runs, figure, scene)
        means[scene] = fmean(values) if values else nan
    row: Row = {f"{figure}_{scene}": mean for scene, mean in means.items()}
    row[f"{figure}_avg"] = fmean(means.values()) if means else nan
    return row


def scene_spreads(runs: Sequence[Run], figure: str, scenes: Sequence[str]) -> Row:
    """``figure_std_<scene>`` and ``figure_std_avg``: spread over seeds; NaN below two seeds."""
    row: Row = {f"{figure}_std_{scene}": _spread(_values(runs, figure, scene)) for scene in scenes}
    row[f"{figure}_std_avg"] = spread_of_average(runs, figure, scenes)
    return row


def within_spread(
    runs: Sequence[Run], reference: Sequence[Run], figure: str, scenes: Sequence[str]
) -> list[str]:
    """Of ``figure_<scene>`` and ``figure_avg`` those that seeds do not tell apart from a reference.

    That is so where the difference of the means is no larger than the larger of the two spreads; it
    is not said where either has fewer than two seeds.
    """
    means, others = (scene_means(each, figure, scenes) for each in (runs, reference))
    spreads, other_spreads = (scene_spreads(each, figure, scenes) for each in (runs, reference))
    alike = []
    for place in (*scenes, "avg"):
        name, spread = f"{figure}_{place}", f"{figure}_std_{place}"
        difference = abs(float(means[name]) - float(others[name]))
        both = (float(spreads[spread]), float(other_spreads[spread]))
        if not any(map(isnan, both)) and difference <= max(both):
            alike.append(name)
    return alike


def spread_of_average(runs: Sequence[Run], figure: str, scenes: Sequence[str]) -> float:
    """Spread over seeds of the average over scenes; only seeds that all scenes have count."""
    averages = []
    for seed in sorted({run.seed for run in runs}):
        values = [_values([r for r in runs if r.seed == seed], figure, scene) for scene in scenes]
        if values and all(values):
            averages.append(fmean(value[0] for value in values))
    return _spread(averages)


def _values(runs: Sequence[Run], figure: str, scene: str) -> list[float]:
    return [run.figures[figure] for run in runs if run.scene == scene and figure in run.figures]


def _spread(values: Sequence[float]) -> float:
    return stdev(values) if len(values) > 1 else nan


def provenance(runs: Sequence[Run]) -> Row:
    """Where a row comes from; several values are joined by ``;``. Nothing measured with a clock."""

    def joined(key: str) -> str:
        return ";".join(in_order([str(run.provenance[key]) for run in runs]))

    return {
        "seeds": ";".join(str(seed) for seed in sorted({run.seed for run in runs})),
        "settings_digest": joined("settings_digest"),
        "code_version": joined("code_version"),
        "iterations": joined("iterations"),
        "num_gaussians_mean": fmean(run.num_gaussians for run in runs),
        "num_threads": joined("num_threads"),
        "machine": joined("machine"),
    }
