"""The tables over methods: table1 (CSV, Markdown, LaTeX) and ablations (CSV).

Rows and scene columns come in the order of the metrics files given, so the same files give the
same bytes. Only training time and peak memory differ between repetitions of a run.
"""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from r3gw.files import InputError
from r3gw.reporting.tables.printed import latex, markdown, write_csv, write_text
from r3gw.reporting.tables.runs import ALL_FIGURES, GAINS, IMAGE_FIGURES, METRICS, Run, load_runs
from r3gw.reporting.tables.summary import (
    Row,
    in_order,
    of_variant,
    provenance,
    scene_means,
    scene_spreads,
    scenes_with,
    spread_of_average,
)

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
    write_csv(frame, target)
    places = [*in_order([run.scene for run in runs]), "avg"]
    write_text(markdown(frame, places), target.with_suffix(".md"))
    write_text(latex(frame, places), target.with_suffix(".tex"))


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
    write_csv(pd.DataFrame(rows), target)


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
    for figure in IMAGE_FIGURES:
        if scenes := scenes_with(runs, figure):
            row |= scene_means(own, figure, scenes)
    for gain in GAINS.values():
        if scenes := scenes_with(runs, gain):
            row |= scene_means(own, gain, scenes)
    row["n_seeds"] = _num_seeds(own)
    leading = "psnr" if scenes_with(runs, "psnr") else "psnr_learned"
    row["psnr_std_avg"] = spread_of_average(own, leading, scenes_with(runs, leading))
    return row | {"variant": variant} | provenance(own)


def _num_seeds(runs: Sequence[Run]) -> int:
    return len({run.seed for run in runs})
