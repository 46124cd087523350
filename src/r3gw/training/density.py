"""Adaptive density: clone, split and prune both sets, and reset opacities.

Statistics follow Kerbl et al. (2023): the mean, over the views that saw a Gaussian, of the norm
of the screen-space position gradient in NDC units. How many grow: `r3gw.training.growth`.
"""

from collections.abc import Mapping
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.optim import Optimizer

from r3gw.geometry.rotations import rotation_from_quaternion
from r3gw.geometry.spherical import direction_from_angles
from r3gw.model.attributes import OPACITY
from r3gw.model.foreground import too_large
from r3gw.model.model import SceneModel
from r3gw.model.rows import Rows
from r3gw.native import kernels, ops
from r3gw.training.growth import Growth
from r3gw.training.settings import DensitySettings

SPLIT_SHRINK = 1.6


class Grown(NamedTuple):
    """Which sets would have grown more if they might."""

    foreground_capped: bool
    sky_capped: bool


UNCAPPED = Grown(foreground_capped=False, sky_capped=False)


class GradientStatistics:
    """Sums of screen-space gradient norms since the last densification, foreground then sky."""

    def __init__(self, count: int, device: torch.device | str = "cpu") -> None:
        """Start empty for ``count`` Gaussians, on the device where they are."""
        self.total = torch.zeros(count, device=device)
        self.views = torch.zeros(count, device=device)

    @classmethod
    def of(cls, model: SceneModel) -> "GradientStatistics":
        """Start empty for all Gaussians of a model."""
        return cls(model.num_gaussians, model.foreground["means"].device)

    def add(
        self,
        gradient_px: Float[Tensor, "n 2"],
        radii_px: Float[Tensor, "n"],
        width: int,
        height: int,
    ) -> None:
        """Take in one view's gradients with respect to pixel positions."""
        # A pixel is 2 / width of the NDC range [-1, 1].
        x, y = 0.5 * width, 0.5 * height
        if kernels.take("add_gradient_norms", self.total, gradient_px, radii_px):
            ops.add_gradient_norms(self.total, self.views, gradient_px, radii_px, x, y)
            return
        is_visible = radii_px > 0
        norm = torch.hypot(x * gradient_px[:, 0], y * gradient_px[:, 1])
        self.total += torch.where(is_visible, norm, 0.0)
        self.views += is_visible

    def mean(self) -> Float[Tensor, "n"]:
        """Mean gradient norm; 0 for Gaussians that no view saw."""
        return self.total / self.views.clamp_min(1.0)


def densify(
    model: SceneModel,
    optimizer: Optimizer,
    gradients: Float[Tensor, "n"],
    settings: DensitySettings,
    *,
    growth: Growth,
    extent: float,
    prune_huge: bool,
    sky_stays: bool,
    generator: torch.Generator,
) -> Grown:
    """Clone or split every Gaussian above the threshold, then prune, in both sets.

    Args:
        model: Changed in place.
        optimizer: Its state follows the rows.
        gradients: Mean NDC gradient norms, foreground first.
        settings: Sizes, opacities and the share of the sky.
        growth: How many there may be, and above which gradient norm one is densified.
        extent: Camera extent, world units; sizes are judged relative to it, in the sky
            relative to the dome's radius where that is larger.
        prune_huge: Whether too large Gaussians go, as they do after the first opacity reset.
        sky_stays: Whether the sky's Gaussians stay as they are.
        generator: Draws the positions of split children.
    """
    split_at = len(model.foreground)
    most, threshold = growth
    budget = most - model.num_gaussians
    sky_extent = max(extent, float(model.sky.radius.detach()))
    capped = []
    for rows, grads, size in (
        (model.foreground, gradients[:split_at], extent),
        (model.sky.rows, gradients[split_at:], sky_extent),
    ):
        room = budget
        if rows is model.sky.rows and sky_stays:
            capped.append(False)
            continue
        if rows is model.sky.rows:
            room = min(room, int(settings.sky_share * most) - len(rows))
        chosen = _strongest(grads, threshold, room)
        capped.append(int(chosen.sum()) < int((grads > threshold).sum()))
        if len(rows) == 0:
            continue
        budget -= int(chosen.sum())
        is_large = too_large(rows["log_scales"], settings.large_scale * size)
        huge = settings.huge_scale * size if prune_huge else float("inf")
        _grow(model, rows, optimizer, chosen & ~is_large, chosen & is_large, generator)
        _prune(rows, optimizer, settings.min_opacity, huge)
    return Grown(*capped)


def reset_opacity(model: SceneModel, optimizer: Optimizer, highest: float) -> None:
    """Lower all opacities to at most ``highest``."""
    ceiling = torch.logit(torch.tensor(highest))
    for rows in (model.foreground, model.sky.rows):
        if len(rows):
            rows.overwrite(optimizer, OPACITY.name, rows[OPACITY.name].clamp(max=ceiling))


def _strongest(grads: Float[Tensor, "n"], threshold: float, budget: int) -> Bool[Tensor, "n"]:
    """Mark gradients above ``threshold``, at most ``budget`` of them, the strongest first."""
    chosen = grads > threshold
    if int(chosen.sum()) > max(budget, 0):
        chosen = torch.zeros_like(chosen)
        chosen[torch.argsort(grads, descending=True, stable=True)[: max(budget, 0)]] = True
    return chosen


def _grow(
    model: SceneModel,
    rows: Rows,
    optimizer: Optimizer,
    is_cloned: Bool[Tensor, "n"],
    is_split: Bool[Tensor, "n"],
    generator: torch.Generator,
) -> None:
    """Append copies of cloned rows and two children per split row; drop the split parents."""
    copies = {name: value.detach()[is_cloned] for name, value in rows.values.items()}
    children = split_children(model, rows, is_split, generator)
    added = {name: torch.cat([copies[name], children[name]]) for name in copies}
    rows.rebuild(optimizer, torch.nonzero(~is_split).squeeze(-1), added)


def split_children(
    model: SceneModel, rows: Rows, is_split: Bool[Tensor, "n"], generator: torch.Generator
) -> Mapping[str, Tensor]:
    """Two children per parent: positions drawn from the parent, scales divided by 1.6."""
    parents = {name: value.detach()[is_split] for name, value in rows.values.items()}
    children = {name: value.repeat_interleave(2, dim=0) for name, value in parents.items()}
    scales = children["log_scales"].exp()
    local = torch.randn(scales.shape, generator=generator) * scales
    offsets = (rotation_from_quaternion(children["quaternions"]) @ local[..., None]).squeeze(-1)
    children["log_scales"] = (scales / SPLIT_SHRINK).log()
    if "means" in children:
        children["means"] = children["means"] + offsets
    else:  # the sky: back onto the hemisphere, then to angles again
        theta, phi = children["angles"].unbind(-1)
        sky = model.sky
        positions = sky.centre + sky.radius.detach() * direction_from_angles(theta, phi)
        children["angles"] = sky.angles_of(positions + offsets)
    return children


def _prune(rows: Rows, optimizer: Optimizer, min_opacity: float, huge: float) -> None:
    """Drop rows that are nearly transparent or larger than ``huge`` world units."""
    opacity = OPACITY.of(rows).detach()
    is_kept = (opacity >= min_opacity) & ~too_large(rows["log_scales"], huge)
    none = {name: value.detach()[:0] for name, value in rows.values.items()}
    rows.rebuild(optimizer, torch.nonzero(is_kept).squeeze(-1), none)
