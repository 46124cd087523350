"""The table of a study: quality of every change beside what it costs, against one baseline.

Figures are means over scenes of means over seeds (`r3gw.reporting.tables.summary`). What a change
is comes from the settings.json of the runs, so the table cannot say anything else than what was
trained.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from r3gw.files import InputError
from r3gw.reporting.tables.printed import write_csv, write_text
from r3gw.reporting.tables.runs import Run, load_runs
from r3gw.reporting.tables.summary import (
    Row,
    in_order,
    of_variant,
    provenance,
    scene_means,
    scenes_with,
    spread_of_average,
)

FIGURES = {
    "psnr_exact": ("PSNR, true light", 2),
    "psnr": ("PSNR, nerf-osr", 2),
    "psnr_linear": ("PSNR, nerf-osr-linear", 2),
    "ssim_exact": ("SSIM, true light", 3),
    "ssim": ("SSIM, nerf-osr", 3),
    "psnr_learned": ("PSNR, learned", 2),
    "sky_boundary_psnr": ("PSNR, outline", 2),
    "sky_foreground_alpha": ("foreground opacity on sky", 3),
}
GAINED = ("psnr_exact", "psnr", "psnr_learned")


def study_table(metrics_files: Sequence[Path], baseline: str, target: Path) -> pd.DataFrame:
    """Write one row per variant as ``target`` (.csv) and, beside it, as .md.

    Columns are the change, the mean seconds of a training, then per figure of `FIGURES` (dB for
    PSNR) its mean ``_avg``, its spread between seeds ``_std_avg`` and, for PSNR, ``gain_`` over the
    baseline, the number of Gaussians, and where the row comes from. Figures that no scene has are
    left out.

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
    settings = {run.variant: _settings(path) for run, path in zip(runs, metrics_files, strict=True)}
    rows = [
        _row(runs, variant, baseline, changed(settings[baseline], settings[variant]))
        for variant in variants
    ]
    frame = pd.DataFrame(rows)
    write_csv(frame, target)
    write_text(_markdown(frame), target.with_suffix(".md"))
    return frame


def changed(before: Mapping[str, Any], after: Mapping[str, Any]) -> str:
    """What differs between two runs' settings but the seed, as ``group.key old → new``."""
    old, new = dict(_leaves(before)), dict(_leaves(after))
    keys = [key for key in in_order([*old, *new]) if key != "seed"]
    return ", ".join(
        f"{key} {_spoken(old, key)} → {_spoken(new, key)}"
        for key in keys
        if old.get(key) != new.get(key)
    )


def _row(runs: Sequence[Run], variant: str, baseline: str, change: str) -> Row:
    own, base = of_variant(runs, variant), of_variant(runs, baseline)
    source = provenance(own)
    row: Row = {"variant": variant, "change": change}
    row["training_seconds_mean"] = source["training_seconds_mean"]
    for figure in FIGURES:
        if not (scenes := scenes_with(runs, figure)):
            continue
        mean, reference = (_average(each, figure, scenes) for each in (own, base))
        row[f"{figure}_avg"] = mean
        row[f"{figure}_std_avg"] = spread_of_average(own, figure, scenes)
        if figure in GAINED:
            row[f"gain_{figure}_avg"] = mean - reference
    return row | {"num_gaussians_mean": source["num_gaussians_mean"]} | source


def _average(runs: Sequence[Run], figure: str, scenes: Sequence[str]) -> float:
    return float(scene_means(runs, figure, scenes)[f"{figure}_avg"])


def _settings(metrics_file: Path) -> dict[str, Any]:
    path = metrics_file.parent.with_name("settings.json")
    try:
        settings: dict[str, Any] = json.loads(path.read_text())
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; train the run again") from None
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not readable as JSON ({error}); train the run again") from None
    return settings


def _leaves(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in settings.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def _spoken(leaves: Mapping[str, Any], key: str) -> str:
    return json.dumps(leaves[key]).strip('"') if key in leaves else "absent"


def _markdown(frame: pd.DataFrame) -> str:
    """The table for people: spread between seeds in brackets, gains signed."""
    shown = pd.DataFrame({"Variant": frame["variant"], "Change": frame["change"]})
    shown["Training (s)"] = frame["training_seconds_mean"].map("{:.1f}".format)
    for figure, (heading, digits) in FIGURES.items():
        if f"{figure}_avg" not in frame:
            continue
        means, spreads = frame[f"{figure}_avg"], frame[f"{figure}_std_avg"]
        shown[heading] = [
            _text(mean, f".{digits}f") + (f" ({spread:.{digits}f})" if pd.notna(spread) else "")
            for mean, spread in zip(means, spreads, strict=True)
        ]
        if figure in GAINED:
            gains = frame[f"gain_{figure}_avg"]
            shown[f"Gain, {heading.split(', ')[1]}"] = [_text(gain, "+.2f") for gain in gains]
    shown["Gaussians"] = frame["num_gaussians_mean"].map("{:,.0f}".format)
    return shown.to_markdown(index=False, disable_numparse=True) + "\n"


def _text(value: float, form: str) -> str:
    return "" if pd.isna(value) else format(value, form).replace("-", "−")
