"""How much both sets of Gaussians may grow at one densification, and what counts as strong."""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.training.schedule import Schedule
from r3gw.training.settings import DensitySettings


class Growth(NamedTuple):
    """One densification.

    Attributes:
        most: The largest number of Gaussians of both sets afterwards.
        threshold: Gradient norm above which a Gaussian is densified.
    """

    most: int
    threshold: float


def growth_at(
    iteration: int,
    gradients: Float[Tensor, "n"],
    settings: DensitySettings,
    schedule: Schedule,
) -> Growth:
    """What the settings allow after an iteration.

    Args:
        iteration: Counts from 1; one after which Gaussians are densified.
        gradients: Mean gradient norms of all Gaussians.
        settings: Their largest number, and how it is reached.
        schedule: Says how many densifications are left, and what the photos' size is worth.
    """
    most = round(schedule.gaussians_share(iteration) * settings.max_gaussians)
    if settings.growth == "even":
        room = max(most - len(gradients), 0) // schedule.densifications_left(iteration)
        return Growth(len(gradients) + room, threshold_of_strongest(gradients, room))
    progress = schedule.density_progress(iteration)
    threshold = rising_threshold(progress, settings.threshold_first, settings.threshold_last)
    return Growth(most, threshold)


def rising_threshold(progress: float, first: float, last: float | None) -> float:
    """Densification threshold, exponential between ``first`` (progress 0) and ``last`` (1).

    Without ``last`` it stays the first.
    """
    if last is None:
        return first
    share = min(max(progress, 0.0), 1.0)
    return float(first * (last / first) ** share)


def threshold_of_strongest(gradients: Float[Tensor, "n"], count: int) -> float:
    """The norm that ``count`` gradients exceed, or fewer where several are equal or zero."""
    if count == 0:
        return float("inf")
    if count >= len(gradients):
        return 0.0
    return float(torch.kthvalue(gradients, len(gradients) - count).values)
