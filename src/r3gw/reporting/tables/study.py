"""The table of a study: quality of every change beside what it costs, against one baseline.

Figures are means over scenes of means over seeds (`r3gw.reporting.tables.summary`). What a change
is comes from the settings.json of the runs, so the table cannot say anything else than what was
trained.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

import pandas as pd

from r3gw.evaluation.metrics import METRICS
from r3gw.evaluation.protocols import facts
from r3gw.files import InputError
from r3gw.reporting.changes import changes, read_settings
from r3gw.reporting.runs import Run, load_runs
from r3gw.reporting.tables.panels import DIGITS
from r3gw.reporting.tables.printed import write_csv, write_text
from r3gw.reporting.tables.summary import (
    Row,
    in_order,
    of_variant,
    provenance,
    scene_means,
    scenes_with,
    spread_of_average,
)


@dataclass(frozen=True)
class Compared:
    """A figure by which a study compares.

    Attributes:
        column: Its name in tables.
        metric: What it is, in print.
        light: Under which light; "outline" and the like for what is no protocol's.
        digits: Digits behind the point, in print.
        has_gain: Whether its difference to the baseline is shown.
        is_test: Whether test views are scored.
    """

    column: str
    metric: str
    light: str
    digits: int
    has_gain: bool = False
    is_test: bool = False

    @property
    def heading(self) -> str:
        """``PSNR, true light``."""
        return f"{self.metric}, {self.light}"


def compared_figures() -> list[Compared]:
    """What a study shows: what protocols name for it, PSNR first, then the sky's outline."""
    ranked = sorted(facts.PROTOCOLS, key=lambda protocol: protocol.rank)
    of_protocols = [
        Compared(
            f"{metric}{each.suffix}",
            metric.upper(),
            each.light_title,
            DIGITS[metric],
            has_gain=metric == "psnr",
            is_test=each.split == "test",
        )
        for metric in METRICS
        for each in ranked
        if metric in each.study_metrics
    ]
    return [
        *of_protocols,
        Compared("sky_boundary_psnr", "PSNR", "outline", 2),
        Compared("sky_foreground_alpha", "foreground opacity", "on sky", 3),
    ]


def study_table(metrics_files: Sequence[Path], baseline: str, target: Path) -> pd.DataFrame:
    """Write one row per variant as ``target`` (.csv) and, beside it, as .md.

    Columns are the change, the mean seconds of a training, then per figure of `compared_figures`
    (dB for PSNR) its mean ``_avg``, its spread between seeds ``_std_avg`` and, for PSNR, ``gain_``
    over the baseline, the number of Gaussians, and where the row comes from. Figures that no scene
    has are left out.

    Args:
        metrics_files: metrics.json of every run, in its run's folder: metrics/ beside
            settings.json.
        baseline: The variant that all others are compared with.
        target: results/study.csv.

    Returns:
        The table, a row per variant in the order of the files.

    Raises:
        InputError: If a file is missing or malformed, or no run is of the baseline.
    """
    runs = load_runs(metrics_files)
    variants = in_order([run.variant for run in runs])
    if baseline not in variants:
        raise InputError(
            f"no run is of the study's baseline '{baseline}', there are {', '.join(variants)}; "
            "evaluate it too"
        )
    settings = {run.variant: read_settings(run.folder.parent) for run in runs}
    rows = []
    for variant in variants:
        changed = changes(settings[baseline], settings[variant])
        text = ", ".join(f"{each.key} {each.before} → {each.after}" for each in changed)
        rows.append(_row(runs, variant, baseline, text))
    frame = pd.DataFrame(rows)
    write_csv(frame, target)
    write_text(_markdown(frame), target.with_suffix(".md"))
    return frame


def _row(runs: Sequence[Run], variant: str, baseline: str, change: str) -> Row:
    own, base = of_variant(runs, variant), of_variant(runs, baseline)
    source = provenance(own)
    row: Row = {"variant": variant, "change": change}
    row["training_seconds_mean"] = fmean(run.cost["training_seconds"] for run in own)
    for figure in compared_figures():
        name = figure.column
        if not (scenes := scenes_with(runs, name)):
            continue
        mean, reference = (_average(each, name, scenes) for each in (own, base))
        row[f"{name}_avg"] = mean
        row[f"{name}_std_avg"] = spread_of_average(own, name, scenes)
        if figure.has_gain:
            row[f"gain_{name}_avg"] = mean - reference
    row["peak_rss_mb_max"] = max(run.cost["training_peak_rss_mb"] for run in own)
    return row | {"num_gaussians_mean": source["num_gaussians_mean"]} | source


def _average(runs: Sequence[Run], figure: str, scenes: Sequence[str]) -> float:
    return float(scene_means(runs, figure, scenes)[f"{figure}_avg"])


def _markdown(frame: pd.DataFrame) -> str:
    """The table for people: spread between seeds in brackets, gains signed."""
    shown = pd.DataFrame({"Variant": frame["variant"], "Change": frame["change"]})
    shown["Training (s)"] = frame["training_seconds_mean"].map("{:.1f}".format)
    for figure in compared_figures():
        name, form = figure.column, f".{figure.digits}f"
        if f"{name}_avg" not in frame:
            continue
        means, spreads = frame[f"{name}_avg"], frame[f"{name}_std_avg"]
        shown[figure.heading] = [
            _text(mean, form) + (f" ({spread:{form}})" if pd.notna(spread) else "")
            for mean, spread in zip(means, spreads, strict=True)
        ]
        if figure.has_gain:
            gains = frame[f"gain_{name}_avg"]
            shown[f"Gain, {figure.light}"] = [_text(gain, "+.2f") for gain in gains]
    shown["Gaussians"] = frame["num_gaussians_mean"].map("{:,.0f}".format)
    return shown.to_markdown(index=False, disable_numparse=True) + "\n"


def _text(value: float, form: str) -> str:
    return "" if pd.isna(value) else format(value, form).replace("-", "−")
