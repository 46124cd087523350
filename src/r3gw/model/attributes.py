"""Everything that is learned of one Gaussian, declared once: rows, first values, rates, columns.

Rows are kept as they are learned, before an activation. What draws a new attribute (the shading
kernels and their plain form) must be told of it in its own place; everything else reads this table.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from scipy.spatial import cKDTree
from torch import Tensor

from r3gw.model.rows import Rows
from r3gw.model.settings import InitSettings

Values = Float[Tensor, "n ..."]
FirstRows = Callable[[Float[Tensor, "n 3"], InitSettings], Values]


def unchanged(rows: Values) -> Values:
    """The activation of what is learned as it is."""
    return rows


@dataclass(frozen=True)
class Attribute:
    """One attribute of a Gaussian.

    Attributes:
        name: Name of the parameter that holds its rows.
        shape: Shape of one Gaussian's row; ``()`` is one number.
        first: First rows of Gaussians at given positions; None where the caller knows them.
        rate: Learning rate, a name of `r3gw.training.settings.RateSettings.named`.
        activate: Turns rows into the values that are drawn.
        columns: PLY columns; none where a file holds something else in its place.
        material: What shading calls the value; None for what is no property of the surface.
    """

    name: str
    shape: tuple[int, ...]
    first: FirstRows | None
    rate: str
    activate: Callable[[Values], Values] = unchanged
    columns: tuple[str, ...] = ()
    material: str | None = None

    def of(self, rows: Rows) -> Values:
        """What is drawn of it."""
        return self.activate(rows[self.name])


def _logits(name: str, shape: tuple[int, ...]) -> FirstRows:
    """The same value, named in the settings, for all Gaussians, before a sigmoid."""

    def first(xyz: Float[Tensor, "n 3"], init: InitSettings) -> Values:
        value: float = getattr(init, name)
        return torch.logit(torch.full((len(xyz), *shape), value))

    return first


def _unturned(xyz: Float[Tensor, "n 3"], _: InitSettings) -> Values:
    return torch.tensor([1.0, 0.0, 0.0, 0.0]).repeat(len(xyz), 1)


def _spaced(xyz: Float[Tensor, "n 3"], _: InitSettings) -> Values:
    """Log of the mean distance to the 3 nearest neighbours, the same for all axes.

    Fewer than 4 points take what neighbours there are; a lone point gets scale 0.1.
    """
    neighbours = min(3, len(xyz) - 1)
    if neighbours < 1:
        return torch.full((len(xyz), 3), 0.1).log()
    points = xyz.double().numpy()
    distances = np.asarray(cKDTree(points).query(points, k=neighbours + 1)[0])
    mean = torch.from_numpy(distances[:, 1:].mean(axis=1)).float().clamp_min(1e-6)
    return mean.log()[:, None].repeat(1, 3)


def _columns(name: str, count: int) -> tuple[str, ...]:
    return tuple(f"{name}_{i}" for i in range(count))


MEANS = Attribute("means", (3,), lambda xyz, _: xyz.clone(), "position", columns=("x", "y", "z"))
ANGLES = Attribute("angles", (2,), None, "position")
LOG_SCALES = Attribute("log_scales", (3,), _spaced, "scale", torch.exp, _columns("scale", 3))
QUATERNIONS = Attribute("quaternions", (4,), _unturned, "rotation", columns=_columns("rot", 4))
OPACITY = Attribute(
    "opacity_logits", (), _logits("opacity", ()), "opacity", torch.sigmoid, ("opacity",)
)
ALBEDO = Attribute(
    "albedo_logits",
    (3,),
    _logits("albedo", (3,)),
    "albedo",
    torch.sigmoid,
    _columns("albedo", 3),
    "albedo",
)
ROUGHNESS = Attribute(
    "roughness_logits",
    (),
    _logits("roughness", ()),
    "roughness",
    torch.sigmoid,
    ("roughness",),
    "roughness",
)

# In the order in which r3gw.rendering.splats hands them to its kernel.
FOREGROUND = (MEANS, LOG_SCALES, QUATERNIONS, OPACITY, ALBEDO, ROUGHNESS)
SKY = (ANGLES, LOG_SCALES, QUATERNIONS, OPACITY)
MATERIALS = {a.material: a for a in FOREGROUND if a.material is not None}


def first_rows(
    attributes: Sequence[Attribute], xyz: Float[Tensor, "n 3"], init: InitSettings
) -> dict[str, Values]:
    """First rows of all attributes that follow from the Gaussians' positions."""
    return {a.name: a.first(xyz, init) for a in attributes if a.first is not None}


def materials_of(foreground: Rows) -> dict[str, Values]:
    """What surfaces are made of, activated, by name."""
    return {name: attribute.of(foreground) for name, attribute in MATERIALS.items()}
