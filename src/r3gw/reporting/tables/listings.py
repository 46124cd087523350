"""Tables with one row per run or per image: runs, decomposition, cost, images (CSV)."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from r3gw.reporting.columns import DECOMPOSITION, all_columns
from r3gw.reporting.runs import Run, load_runs
from r3gw.reporting.tables.printed import write_csv
from r3gw.reporting.tables.summary import Row, scenes_with

SECONDS_PER_MINUTE = 60.0
TRACE = ("settings_digest", "code_version", "iterations", "num_threads", "machine")


def runs_table(metrics_files: Sequence[Path], target: Path) -> None:
    """Write one row per scene, variant and seed with all image metrics and provenance.

    Raises:
        InputError: If a file is missing or malformed.
    """
    _write_per_run(load_runs(metrics_files), all_columns(), target)


def decomposition(metrics_files: Sequence[Path], target: Path) -> None:
    """Write one row per scene, variant and seed: albedo, normals, depth, light, sky boundary.

    Raises:
        InputError: If a file is missing or malformed.
    """
    _write_per_run(load_runs(metrics_files), DECOMPOSITION, target)


def cost(metrics_files: Sequence[Path], target: Path) -> None:
    """Write what each run cost: training minutes, peak memory, Gaussians, renders per second.

    Raises:
        InputError: If a file is missing or malformed.
    """
    rows = []
    for run in load_runs(metrics_files):
        figures: Row = {
            "training_minutes": run.cost["training_seconds"] / SECONDS_PER_MINUTE,
            "training_peak_rss_mb": run.cost["training_peak_rss_mb"],
            "num_gaussians": run.num_gaussians,
            "num_foreground": int(run.provenance["num_foreground"]),
            "num_sky": int(run.provenance["num_sky"]),
            "renders_per_second": run.cost["renders_per_second"],
            "render_megapixels": run.cost["render_megapixels"],
            "render_threads": run.cost["render_threads"],
            "evaluation_peak_rss_mb": run.cost["peak_rss_mb"],
        }
        rows.append(_key(run) | figures | _trace(run))
    write_csv(pd.DataFrame(rows), target)


def images_table(metrics_files: Sequence[Path], target: Path) -> None:
    """Write one row per run, protocol and image: every single number of the records.

    Raises:
        InputError: If a file is missing or malformed.
    """
    rows = []
    for run in load_runs(metrics_files):
        for record in run.images:
            single = {key: value for key, value in record.items() if not isinstance(value, list)}
            rows.append(single | _key(run) | _trace(run))
    frame = pd.DataFrame(rows)
    leading = ["scene", "variant", "seed", "protocol", "view", "psnr", "ssim", "mse", "mae"]
    others = [name for name in frame.columns if name not in leading]
    write_csv(frame[[*leading, *others]], target)


def _key(run: Run) -> Row:
    return {"scene": run.scene, "variant": run.variant, "seed": run.seed}


def _trace(run: Run) -> Row:
    return {key: run.provenance[key] for key in TRACE}


def _write_per_run(runs: Sequence[Run], figures: Sequence[str], target: Path) -> None:
    present = [figure for figure in figures if scenes_with(runs, figure)]
    rows = []
    for run in runs:
        row = _key(run)
        row |= {figure: run.figures.get(figure, float("nan")) for figure in present}
        single = {k: v for k, v in run.provenance.items() if not isinstance(v, dict | list)}
        rows.append(row | {k: v for k, v in single.items() if k not in row})
    write_csv(pd.DataFrame(rows), target)
