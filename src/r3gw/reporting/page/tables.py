"""The tables of the report, as texts for the template."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from r3gw.evaluation.metrics import METRICS
from r3gw.reporting.columns import gain_columns
from r3gw.reporting.tables.panels import DIGITS, NOTE, panels

Page = dict[str, Any]

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
PROVENANCE = ("method", "settings_digest", "code_version", "iterations", "seeds", "machine")


def table1_page(table: pd.DataFrame, scenes: Sequence[str]) -> Page:
    """Table 1 by protocol; figures of a row in the order of places and metrics.

    Args:
        table: Rows of table1.csv.
        scenes: Names, in the order in which they are shown.
    """
    shown = list(panels(table, [*scenes, "avg"]))
    return {
        "panels": [
            {
                "title": panel.title,
                "rows": [
                    {"method": method, "figures": [figure.text for figure in figures]}
                    for method, figures in panel.rows.items()
                ],
            }
            for panel in shown
        ],
        "places": [*scenes, "average"],
        "metrics": [metric.upper() for metric in METRICS],
        "gain": _gains(table),
        "note": NOTE if any(panel.has_spread for panel in shown) else "",
    }


def listing(frame: pd.DataFrame, columns: dict[str, tuple[str, int]]) -> Page:
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


def provenance(table: pd.DataFrame) -> list[Page]:
    """Where the measured rows of table 1 come from."""
    measured = table[table["group"].str.startswith("measured")]
    return [{key: row[key] for key in PROVENANCE} for _, row in measured.iterrows()]


def _text(value: Any, digits: int) -> str:
    return "" if pd.isna(value) else f"{float(value):,.{digits}f}"


def _gains(table: pd.DataFrame) -> str:
    """What the oracles' sweeps bring the first method over the true light; empty if unknown."""
    row = table.iloc[-1] if "variant" not in table else table[table["variant"].notna()].iloc[0]
    parts = []
    for protocol, name in gain_columns().items():
        column = f"{name}_avg"
        if column in table.columns and pd.notna(row[column]):
            gain = f"{row[column]:+.{DIGITS['psnr']}f}".replace("-", "−")
            parts.append(f"{protocol} {gain} dB")
    return ", ".join(parts)
