"""The report: one HTML page that needs no other file and no network."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.reporting.figures.style import look
from r3gw.reporting.page.scene_page import Page, SceneFolders, scene_page
from r3gw.reporting.tables.printed import DIGITS, panels, write_text
from r3gw.reporting.tables.runs import METRICS

# Columns of decomposition.csv and cost.csv that the page shows: heading and digits.
DECOMPOSITION = {
    "albedo_psnr": ("albedo PSNR (dB)", 2),
    "normal_mean_deg": ("normals, mean error (°)", 1),
    "normal_median_deg": ("normals, median error (°)", 1),
    "depth_abs_rel": ("depth, abs. rel. error", 3),
    "light_error_diffuse": ("light error, bands 0–2", 3),
    "sky_boundary_psnr": ("sky boundary PSNR (dB)", 2),
}
COST = {
    "training_minutes": ("training (min)", 2),
    "training_peak_rss_mb": ("peak memory (MB)", 0),
    "num_gaussians": ("Gaussians", 0),
    "renders_per_second": ("renders per second", 1),
    "render_megapixels": ("megapixels each", 3),
    "iterations": ("iterations", 0),
}
WHAT = {"scene": "scene", "variant": "variant", "seed": "seed"}


def write_report(tables: Path, scenes: Sequence[SceneFolders], target: Path) -> None:
    """Write the report.

    Args:
        tables: Folder of table1.csv, decomposition.csv and cost.csv.
        scenes: Scenes and the runs to show of each, the main one first.
        target: The page (.html).

    Raises:
        InputError: If a file is missing.
    """
    frames = {name: _read(tables / f"{name}.csv") for name in ("table1", "decomposition", "cost")}
    names = [each.root.name for each in scenes]
    with look():
        pages = [scene_page(each) for each in tqdm(scenes, desc="report", unit="scene")]
    environment = Environment(
        loader=PackageLoader("r3gw.reporting.page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template("report.html.j2").render(
        panels=_panels(frames["table1"], names),
        metrics=[metric.upper() for metric in METRICS],
        places=[*names, "average"],
        decomposition=_listing(frames["decomposition"], DECOMPOSITION),
        cost=_listing(frames["cost"], COST),
        gain=_gains(frames["table1"]),
        scenes=pages,
        provenance=_provenance(frames["table1"]),
    )
    write_text(page, target)


def _read(path: Path) -> pd.DataFrame:
    if not path.is_file():
        raise InputError(f"{path}: no such file; make the tables first")
    return pd.read_csv(path)


def _panels(table: pd.DataFrame, scenes: Sequence[str]) -> list[Page]:
    """Table 1 by protocol, figures of a row in the order of scenes and metrics."""
    names = [f"{metric}_{place}" for place in (*scenes, "avg") for metric in METRICS]
    return [
        {
            "title": title,
            "rows": [
                {"method": row["method"], "figures": [row[name] for name in names]}
                for _, row in panel.iterrows()
            ],
        }
        for title, panel in panels(table, [*scenes, "avg"])
    ]


def _listing(frame: pd.DataFrame, columns: dict[str, tuple[str, int]]) -> Page:
    """Rows of a per-run table as texts; figures that no scene has are left out."""
    shown = {
        name: column
        for name, column in columns.items()
        if name in frame.columns and frame[name].notna().any()
    }
    rows = [
        {
            "what": [str(row[name]) for name in WHAT],
            "figures": [_text(row[name], digits) for name, (_, digits) in shown.items()],
        }
        for _, row in frame.iterrows()
    ]
    return {
        "what": list(WHAT.values()),
        "heads": [head for head, _ in shown.values()],
        "rows": rows,
    }


def _text(value: Any, digits: int) -> str:
    return "" if pd.isna(value) else f"{float(value):,.{digits}f}"


def _gains(table: pd.DataFrame) -> str:
    """What the oracle's sweep brings the first method over the true light; empty if unknown."""
    row = table.iloc[-1] if "variant" not in table else table[table["variant"].notna()].iloc[0]
    parts = []
    for protocol, column in (
        ("nerf-osr", "sweep_gain_psnr_avg"),
        ("full-yaw", "full_yaw_gain_psnr_avg"),
    ):
        if column in table.columns and pd.notna(row[column]):
            gain = f"{row[column]:+.{DIGITS['psnr']}f}".replace("-", "−")
            parts.append(f"{protocol} {gain} dB")
    return ", ".join(parts)


def _provenance(table: pd.DataFrame) -> list[Page]:
    keys = ("method", "settings_digest", "code_version", "iterations", "seeds", "machine")
    measured = table[table["group"].str.startswith("measured")]
    return [{key: row[key] for key in keys} for _, row in measured.iterrows()]
