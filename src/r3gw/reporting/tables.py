"""The tables: table1 (CSV, Markdown, LaTeX), ablations, runs, decomposition (CSV).

Rows and scene columns come in the order of the metrics files given, so the same files give the
same bytes. Only training time and peak memory differ between repetitions of a run.
"""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from r3gw.files import InputError, atomic_path
from r3gw.reporting.runs import DECOMPOSITION, EXTRAS, METRICS, SUFFIXES, SWEEP_GAIN, Run, load_runs
from r3gw.reporting.summary import (
    Row,
    in_order,
    of_variant,
    provenance,
    scene_means,
    scene_spreads,
    scenes_with,
    spread_of_average,
)

FLOAT_FORMAT = "%.6g"
BENCHMARK_SCENES = {"lk2", "lwp", "st"}
METHODS = {
    "full": "r3gw",
    "no_specular": "r3gw without specular",
    "no_sky_depth": "r3gw without sky-depth loss",
    "no_sky_gaussians": "r3gw without sky Gaussians",
    "no_separation": "r3gw without foreground-sky loss",
    "light_degree_2": "r3gw, light of degree 2",
    "constant_threshold": "r3gw, constant densification threshold",
}
PROTOCOL = "nerf-osr"
FIGURES = tuple(f"{metric}{suffix}" for suffix in SUFFIXES.values() for metric in METRICS)
ALL_FIGURES = (*FIGURES, SWEEP_GAIN, *(figure for _, _, figure in EXTRAS), *DECOMPOSITION)
PRINTED_DIGITS = {"psnr": 2, "ssim": 3, "mse": 3, "mae": 3}  # in Markdown and LaTeX


def table1(metrics_files: Sequence[Path], published: Path | None, target: Path) -> None:
    """Write the paper's Table 1 as ``target`` (.csv) and, beside it, as .md and .tex.

    One row per method. Bare metric columns are of protocol nerf-osr, the others carry the
    protocol's name; scenes that lack a protocol have no column of it. Published rows are added
    only if the scenes are exactly the paper's, and are marked so in ``group``.

    Args:
        metrics_files: metrics.json of every run.
        published: The published figures (config/published.csv); None leaves them out.
        target: results/table1.csv.

    Raises:
        InputError: If a file is missing or malformed.
    """
    runs = load_runs(metrics_files)
    rows = [_table1_row(runs, variant) for variant in in_order([run.variant for run in runs])]
    frame = pd.DataFrame(rows)
    if published is not None and {run.scene for run in runs} == BENCHMARK_SCENES:
        frame = pd.concat([read_published(published), frame], ignore_index=True)[frame.columns]
    _write_csv(frame, target)
    printed = _printed(frame, [*scenes_with(runs, "psnr"), "avg"])
    _write_text(
        printed.to_markdown(index=False, disable_numparse=True) + "\n", target.with_suffix(".md")
    )
    _write_text(_latex(printed), target.with_suffix(".tex"))


def ablations(metrics_files: Sequence[Path], target: Path) -> None:
    """Write one row per variant: every figure per scene and on average, with spread over seeds.

    Raises:
        InputError: If a file is missing or malformed.
    """
    runs = load_runs(metrics_files)
    rows = []
    for variant in in_order([run.variant for run in runs]):
        own = of_variant(runs, variant)
        row: Row = {"method": method_name(variant), "variant": variant, "n_seeds": _num_seeds(own)}
        for figure in ALL_FIGURES:
            if scenes := scenes_with(runs, figure):
                row |= scene_means(own, figure, scenes) | scene_spreads(own, figure, scenes)
        rows.append(row | provenance(own))
    _write_csv(pd.DataFrame(rows), target)


def runs_table(metrics_files: Sequence[Path], target: Path) -> None:
    """Write one row per scene, variant and seed with all image metrics and provenance.

    Raises:
        InputError: If a file is missing or malformed.
    """
    _write_per_run(load_runs(metrics_files), ALL_FIGURES, target)


def decomposition(metrics_files: Sequence[Path], target: Path) -> None:
    """Write one row per scene, variant and seed: albedo, normals, depth, light, sky boundary.

    Raises:
        InputError: If a file is missing or malformed.
    """
    _write_per_run(load_runs(metrics_files), DECOMPOSITION, target)


def method_name(variant: str) -> str:
    """How a variant is called in print."""
    return METHODS.get(variant, f"r3gw {variant.replace('_', ' ')}")


def read_published(path: Path) -> pd.DataFrame:
    """Read published figures; their group is marked "published".

    Raises:
        InputError: If the file is missing or lacks the columns of the paper's table.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file; restore config/published.csv")
    frame = pd.read_csv(path, comment="#")
    scenes = [*sorted(BENCHMARK_SCENES), "avg"]
    wanted = ["method", "group", *(f"{metric}_{scene}" for metric in METRICS for scene in scenes)]
    if missing := [column for column in wanted if column not in frame.columns]:
        raise InputError(f"{path}: lacks the columns {', '.join(missing)}; restore them")
    frame["group"] = "published " + frame["group"]
    frame["protocol"] = PROTOCOL
    return frame


def _table1_row(runs: Sequence[Run], variant: str) -> Row:
    own = of_variant(runs, variant)
    group = "measured" if variant == "full" else "measured ablation"
    row: Row = {"method": method_name(variant), "group": group, "protocol": PROTOCOL}
    for figure in FIGURES:
        if scenes := scenes_with(runs, figure):
            row |= scene_means(own, figure, scenes)
    if scenes := scenes_with(runs, SWEEP_GAIN):
        row[f"{SWEEP_GAIN}_avg"] = scene_means(own, SWEEP_GAIN, scenes)[f"{SWEEP_GAIN}_avg"]
    row["n_seeds"] = _num_seeds(own)
    leading = "psnr" if scenes_with(runs, "psnr") else "psnr_learned"
    row["psnr_std_avg"] = spread_of_average(own, leading, scenes_with(runs, leading))
    return row | {"variant": variant} | provenance(own)


def _num_seeds(runs: Sequence[Run]) -> int:
    return len({run.seed for run in runs})


def _write_per_run(runs: Sequence[Run], figures: Sequence[str], target: Path) -> None:
    present = [figure for figure in figures if scenes_with(runs, figure)]
    rows = []
    for run in runs:
        row: Row = {"scene": run.scene, "variant": run.variant, "seed": run.seed}
        row |= {figure: run.figures.get(figure, float("nan")) for figure in present}
        own = dict(run.provenance)
        for key in ("scene", "variant", "seed"):
            own.pop(key)
        rows.append(row | own)
    _write_csv(pd.DataFrame(rows), target)


def _printed(frame: pd.DataFrame, places: Sequence[str]) -> pd.DataFrame:
    """The columns that fit a page, rounded, as text: nerf-osr per scene, exact on average."""
    columns = {"Method": frame["method"], "Group": frame["group"]}
    wanted = [(m, place, f"{m}_{place}") for m in METRICS for place in places]
    wanted += [(m, "exact avg", f"{m}_exact_avg") for m in METRICS]
    for metric, place, name in wanted:
        if name in frame.columns:
            columns[f"{metric.upper()} {place}"] = _rounded(frame[name], PRINTED_DIGITS[metric])
    return pd.DataFrame(columns)


def _rounded(values: pd.Series, digits: int) -> pd.Series:
    return values.map(lambda value: "" if pd.isna(value) else f"{value:.{digits}f}")


def _latex(printed: pd.DataFrame) -> str:
    """A booktabs table; headings and names are escaped."""
    style = printed.style.hide(axis="index").format(escape="latex")
    style = style.format_index(escape="latex", axis="columns")
    alignment = "ll" + "r" * (len(printed.columns) - 2)
    return str(style.to_latex(column_format=alignment, hrules=True))


def _write_csv(frame: pd.DataFrame, target: Path) -> None:
    with atomic_path(target) as path:
        frame.to_csv(path, index=False, float_format=FLOAT_FORMAT)


def _write_text(text: str, target: Path) -> None:
    with atomic_path(target) as path:
        path.write_text(text)
