"""The figures of a run by the names of the tables' columns, as protocols name them.

Metrics of a protocol stand in ``<metric><suffix>``: those of ``nerf-osr`` bare (``psnr``), those
of the others with a suffix (``psnr_exact``, ``psnr_learned``).
"""

from collections.abc import Iterable, Mapping, Sequence
from statistics import fmean
from typing import Any

from r3gw.evaluation.metrics import METRICS
from r3gw.evaluation.protocols import facts
from r3gw.evaluation.protocols.facts import EXACT, ProtocolFacts

Record = Mapping[str, Any]

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


def metric_columns() -> list[str]:
    """Metrics of all protocols."""
    return [f"{metric}{each.suffix}" for each in facts.PROTOCOLS for metric in METRICS]


def gain_columns() -> dict[str, str]:
    """What protocols bring over the true light: column by name of the protocol."""
    return {each.name: each.gain_column for each in facts.PROTOCOLS if each.gain_column}


def all_columns() -> list[str]:
    """Every figure that a run may have."""
    extras = [f"{field}{each.suffix}" for each in facts.PROTOCOLS for field in each.extra_fields]
    return [*metric_columns(), *gain_columns().values(), *extras, *DECOMPOSITION]


def bare_protocol() -> ProtocolFacts:
    """The protocol whose columns have no suffix."""
    return next(each for each in facts.PROTOCOLS if not each.suffix)


def pictured_protocols() -> list[ProtocolFacts]:
    """The protocols whose pictures are shown, the best way to show a view first."""
    pictured = [each for each in facts.PROTOCOLS if each.is_pictured]
    return sorted(pictured, key=lambda protocol: protocol.rank)


def figures_of(images: Sequence[Record], decomposition: Sequence[Record]) -> dict[str, float]:
    """Means over a run's views by column; a figure that the scene does not allow is absent.

    Args:
        images: The record of every image and protocol.
        decomposition: What was compared with ground truth, and the sky's outline.
    """
    found: dict[str, float] = {}
    for protocol in facts.PROTOCOLS:
        means = _means(_of(images, protocol), (*METRICS, *protocol.extra_fields))
        found |= {f"{field}{protocol.suffix}": value for field, value in means.items()}
    exact = {record["view"]: record["psnr"] for record in _of(images, EXACT)}
    for protocol in facts.PROTOCOLS:
        shared = [record for record in _of(images, protocol) if record["view"] in exact]
        if protocol.gain_column and shared:
            gains = [record["psnr"] - exact[record["view"]] for record in shared]
            found[protocol.gain_column] = fmean(gains)
    return {**found, **_means(decomposition, DECOMPOSITION)}


def _of(images: Sequence[Record], protocol: ProtocolFacts) -> list[Record]:
    return [record for record in images if record["protocol"] == protocol.name]


def _means(records: Sequence[Record], names: Iterable[str]) -> Mapping[str, float]:
    """Mean of each field over the records that have it; fields that none has are left out."""
    columns = {name: [record[name] for record in records if name in record] for name in names}
    return {name: fmean(values) for name, values in columns.items() if values}
