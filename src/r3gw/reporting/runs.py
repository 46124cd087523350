"""One training and its evaluation as figures (name -> value); read from metrics.json.

A figure is named as a column of the tables: metrics of protocol ``nerf-osr`` bare (``psnr``),
those of the others with the protocol's name (``psnr_exact``, ``psnr_learned``).
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

from r3gw.files import InputError

METRICS = ("psnr", "ssim", "mse", "mae")
SUFFIXES = {"nerf-osr": "", "exact": "_exact", "learned": "_learned"}
SWEEP_GAIN = "sweep_gain_psnr"
# Figures of single protocols: (protocol, field of its records, figure).
EXTRAS = (
    ("exact", "oracle_psnr", "oracle_psnr_exact"),
    ("learned", "psnr_foreground", "psnr_foreground_learned"),
)
DECOMPOSITION = (
    "albedo_psnr",
    "albedo_psnr_r",
    "albedo_psnr_g",
    "albedo_psnr_b",
    "normal_mean_deg",
    "normal_median_deg",
    "depth_abs_rel",
    "light_error",
    "light_error_diffuse",
    "sky_boundary_psnr",
    "sky_foreground_alpha",
    "sky_in_front",
)


@dataclass(frozen=True)
class Run:
    """One training of one variant on one scene.

    Attributes:
        scene, variant, seed: Which one.
        figures: Means over views; a figure that the scene does not allow is absent.
        provenance: The training's run.json.
    """

    scene: str
    variant: str
    seed: int
    figures: Mapping[str, float]
    provenance: Mapping[str, Any]

    @property
    def num_gaussians(self) -> int:
        """Foreground and sky together."""
        return int(self.provenance["num_foreground"]) + int(self.provenance["num_sky"])


def load_runs(metrics_files: Iterable[Path]) -> list[Run]:
    """Read metrics.json of several runs, in the order given.

    Raises:
        InputError: If there is none, one is missing or malformed, or two are of the same run.
    """
    runs = [_load_run(path) for path in metrics_files]
    if not runs:
        raise InputError("a table needs at least one metrics.json; evaluate a run first")
    seen = set()
    for run in runs:
        key = (run.scene, run.variant, run.seed)
        if key in seen:
            raise InputError(
                f"two metrics.json are of scene {run.scene}, variant {run.variant}, "
                f"seed {run.seed}; give each run once"
            )
        seen.add(key)
    return runs


def _load_run(path: Path) -> Run:
    if not path.is_file():
        raise InputError(f"{path}: no such file; evaluate the run first")
    try:
        content = json.loads(path.read_text())
        provenance = content["run"]
        figures = {
            **_image_figures(content["images"]),
            **_means(content["decomposition"], DECOMPOSITION),
        }
        return Run(
            provenance["scene"], provenance["variant"], provenance["seed"], figures, provenance
        )
    except (json.JSONDecodeError, KeyError, TypeError) as error:
        raise InputError(
            f"{path}: not a metrics file of this version ({error!r}); evaluate the run again"
        ) from error


def _image_figures(records: list[dict[str, Any]]) -> dict[str, float]:
    by_protocol = {
        protocol: [record for record in records if record["protocol"] == protocol]
        for protocol in SUFFIXES
    }
    figures = {
        f"{metric}{suffix}": value
        for protocol, suffix in SUFFIXES.items()
        for metric, value in _means(by_protocol[protocol], METRICS).items()
    }
    for protocol, field, figure in EXTRAS:
        for value in _means(by_protocol[protocol], (field,)).values():
            figures[figure] = value
    swept = {record["view"]: record["psnr"] for record in by_protocol["nerf-osr"]}
    exact = {record["view"]: record["psnr"] for record in by_protocol["exact"]}
    gains = [swept[view] - exact[view] for view in swept if view in exact]
    if gains:
        figures[SWEEP_GAIN] = fmean(gains)
    return figures


def _means(records: list[dict[str, Any]], names: Iterable[str]) -> dict[str, float]:
    """Mean of each field over the records that have it; fields that none has are left out."""
    columns = {name: [record[name] for record in records if name in record] for name in names}
    return {name: fmean(values) for name, values in columns.items() if values}
