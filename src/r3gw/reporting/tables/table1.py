"""The tables over methods: table1 (CSV, Markdown, LaTeX) and ablations (CSV).

Scene columns come in the order of the metrics files given, rows in print order
(`r3gw.reporting.methods`), so the same files give the same bytes.
"""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from r3gw.evaluation.metrics import METRICS
from r3gw.files import InputError
from r3gw.reporting.columns import all_columns, bare_protocol, gain_columns, metric_columns
from r3gw.reporting.methods import in_print_order, method_of
from r3gw.reporting.runs import Run, load_runs
from r3gw.reporting.tables.panels import WITHIN_SPREAD
from r3gw.reporting.tables.printed import latex, markdown, write_csv, write_text
from r3gw.reporting.tables.summary import (
    Row,
    in_order,
    num_seeds,
    of_variant,
    provenance,
    scene_means,
    scene_spreads,
    scenes_with,
    spread_of_average,
    within_spread,
)

BENCHMARK_SCENES = {"lk2", "lwp", "st"}
FULL = "full"


def table1(metrics_files: Sequence[Path], published: Path | None, target: Path) -> None:
    """Write the paper's Table 1 as ``target`` (.csv) and, beside it, as .md and .tex.

    One row per method. Bare metric columns are of protocol nerf-osr, the others carry the
    protocol's suffix; scenes that lack a protocol have no column of it. Where methods were trained
    with several seeds, every figure has its spread beside it (``<metric><suffix>_std_<scene>``),
    and ``within_spread`` names the figures that the seeds do not tell apart from the full method's.
    Published rows are added only if the scenes are exactly the paper's, and are marked so in
    ``group``.

    Args:
        metrics_files: metrics.json of every run.
        published: The published figures (config/published.csv); None leaves them out.
        target: results/table1.csv.

    Raises:
        InputError: If a file is missing or malformed.
    """
    runs = load_runs(metrics_files)
    frame = pd.DataFrame([_table1_row(runs, variant) for variant in _variants(runs)])
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
    for variant in _variants(runs):
        own = of_variant(runs, variant)
        row: Row = {"method": method_of(variant).name, "variant": variant}
        row["n_seeds"] = num_seeds(own)
        for figure in all_columns():
            if scenes := scenes_with(runs, figure):
                row |= scene_means(own, figure, scenes) | scene_spreads(own, figure, scenes)
        rows.append(row | provenance(own))
    write_csv(pd.DataFrame(rows), target)


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
    frame["protocol"] = bare_protocol().name
    return frame


def _variants(runs: Sequence[Run]) -> list[str]:
    return in_print_order(in_order([run.variant for run in runs]))


def _table1_row(runs: Sequence[Run], variant: str) -> Row:
    own, method = of_variant(runs, variant), method_of(variant)
    row: Row = {"method": method.name, "group": method.group, "protocol": bare_protocol().name}
    for figure in metric_columns():
        if scenes := scenes_with(runs, figure):
            row |= scene_means(own, figure, scenes)
    for gain in gain_columns().values():
        if scenes := scenes_with(runs, gain):
            row |= scene_means(own, gain, scenes)
    row["n_seeds"] = num_seeds(own)
    leading = "psnr" if scenes_with(runs, "psnr") else "psnr_learned"
    row["psnr_std_avg"] = spread_of_average(own, leading, scenes_with(runs, leading))
    if any(num_seeds(of_variant(runs, each)) > 1 for each in _variants(runs)):
        row |= _spreads(runs, variant)
    return row | {"variant": variant} | provenance(own)


def _spreads(runs: Sequence[Run], variant: str) -> Row:
    """Spread of every metric, and which of them do not differ from the full method's beyond it."""
    own, full = of_variant(runs, variant), of_variant(runs, FULL)
    row: Row = {}
    alike: list[str] = []
    for figure in metric_columns():
        if scenes := scenes_with(runs, figure):
            row |= scene_spreads(own, figure, scenes)
            alike += within_spread(own, full, figure, scenes)
    return row | {WITHIN_SPREAD: "" if variant == FULL else ";".join(alike)}
