"""One training and its evaluation as figures (name -> value); read from metrics.json.

A figure is named as a column of the tables: metrics of protocol ``nerf-osr`` bare (``psnr``),
those of the others with the protocol's name (``psnr_exact``, ``psnr_learned``).
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

from r3gw.files import InputError

METRICS = ("psnr", "ssim", "mse", "mae")
SUFFIXES = {
    "nerf-osr": "",
    "full-yaw": "_full_yaw",
    "nerf-osr-linear": "_linear",
    "exact": "_exact",
    "learned": "_learned",
}
# What an oracle's sweep brings over the true light: protocol -> figure.
GAINS = {"nerf-osr": "sweep_gain_psnr", "full-yaw": "full_yaw_gain_psnr"}
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

IMAGE_FIGURES = tuple(f"{metric}{suffix}" for suffix in SUFFIXES.values() for metric in METRICS)
ALL_FIGURES = (
    *IMAGE_FIGURES,
    *GAINS.values(),
    *(figure for _, _, figure in EXTRAS),
    *DECOMPOSITION,
)


@dataclass(frozen=True)
class Run:
    """One training of one variant on one scene.

    Attributes:
        scene, variant, seed: Which one.
        figures: Means over views; a figure that the scene does not allow is absent.
        images: The record of every image and protocol.
        provenance: The training's run.json.
        cost: What the evaluation measured with a clock (cost.json).
    """

    scene: str
    variant: str
    seed: int
    figures: Mapping[str, float]
    images: Sequence[Mapping[str, Any]]
    provenance: Mapping[str, Any]
    cost: Mapping[str, float]

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
    measured = path.with_name("cost.json")
    for file in (path, measured):
        if not file.is_file():
            raise InputError(f"{file}: no such file; evaluate the run first")
    try:
        content = json.loads(path.read_text())
        provenance = content["run"]
        figures = {
            **_image_figures(content["images"]),
            **_means(content["decomposition"], DECOMPOSITION),
        }
        return Run(
            scene=provenance["scene"],
            variant=provenance["variant"],
            seed=provenance["seed"],
            figures=figures,
            images=content["images"],
            provenance=provenance,
            cost=json.loads(measured.read_text()),
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
    exact = {record["view"]: record["psnr"] for record in by_protocol["exact"]}
    for protocol, figure in GAINS.items():
        swept = {record["view"]: record["psnr"] for record in by_protocol[protocol]}
        if gains := [swept[view] - exact[view] for view in swept if view in exact]:
            figures[figure] = fmean(gains)
    return figures


def _means(records: list[dict[str, Any]], names: Iterable[str]) -> dict[str, float]:
    """Mean of each field over the records that have it; fields that none has are left out."""
    columns = {name: [record[name] for record in records if name in record] for name in names}
    return {name: fmean(values) for name, values in columns.items() if values}
