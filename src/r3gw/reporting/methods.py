"""What variants are called in print, and which part of a table they belong to."""

from collections.abc import Sequence
from dataclasses import dataclass

PAPER = "measured"
ABLATION = "measured ablation"
BEYOND = "measured, beyond the paper"
OWN = "measured, own settings"


@dataclass(frozen=True)
class Method:
    """A variant in print.

    Attributes:
        name: What tables call it.
        label: What pictures and legends call it, shorter.
        group: `PAPER`, `ABLATION` (a piece of the paper's method left out or changed), `BEYOND` or
            `OWN` (settings of the user's own).
    """

    name: str
    label: str
    group: str


_METHODS = {
    "full": Method("r3gw", "full", PAPER),
    "no_specular": Method("r3gw without specular", "without specular", ABLATION),
    "no_sky_depth": Method("r3gw without sky-depth loss", "without sky-depth loss", ABLATION),
    "no_sky_gaussians": Method("r3gw without sky Gaussians", "without sky Gaussians", ABLATION),
    "no_separation": Method(
        "r3gw without foreground-sky loss", "without foreground-sky loss", ABLATION
    ),
    "light_degree_2": Method("r3gw, light of degree 2", "light of degree 2", ABLATION),
    "constant_threshold": Method(
        "r3gw, constant densification threshold", "constant densification threshold", ABLATION
    ),
    "r3gw_plus": Method("r3gw_plus", "r3gw_plus", BEYOND),
    "r3gw_sun": Method("r3gw_sun", "r3gw_sun", BEYOND),
    "r3gw_sun_known": Method("r3gw_sun, known suns", "r3gw_sun_known", BEYOND),
}
RECOMMENDED = "r3gw_plus"
_GROUPS = (PAPER, ABLATION, BEYOND, OWN)


def method_of(variant: str) -> Method:
    """How a variant is printed; one that this project does not know keeps its own name."""
    label = variant.replace("_", " ")
    return _METHODS.get(variant, Method(f"r3gw, {label}", label, OWN))


def recommended(variants: Sequence[str]) -> str:
    """The variant to show where one is shown: what goes beyond the paper, else the first."""
    return RECOMMENDED if RECOMMENDED in variants else variants[0]


def in_print_order(variants: list[str]) -> list[str]:
    """The paper's method, its ablations, what goes beyond it, one's own; else the order given."""
    return sorted(variants, key=lambda variant: _GROUPS.index(method_of(variant).group))
