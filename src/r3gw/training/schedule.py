"""When things happen: the paper's milestones and intervals, scaled to this run's length."""

from dataclasses import dataclass
from math import exp, floor, log

from r3gw.training.settings import TrainSettings

# Photos grow in steps of an eighth of their sides: each is made small at most so often.
PHOTO_STEPS = 8


def scaled(paper_iteration: int, iterations: int, paper_iterations: int) -> int:
    """Scale an iteration number or interval of the paper's schedule; what was > 0 stays > 0."""
    if paper_iteration == 0:
        return 0
    return max(1, round(paper_iteration * iterations / paper_iterations))


def smaller_photos_share(settings: TrainSettings) -> float:
    """Most pixels that smaller copies of the photos hold at a time, as a share of the photos'."""
    return ((PHOTO_STEPS - 1) / PHOTO_STEPS) ** 2 if settings.resolution.smallest < 1.0 else 0.0


@dataclass(frozen=True)
class Schedule:
    """Milestones in this run's own iterations, which count from 1."""

    iterations: int
    warm_up: int
    geometry_losses_from: int
    densify_first: int
    densify_last: int
    densify_interval: int
    reset_interval: int | None
    position_iterations: int
    rates_fall_from: int
    occlusion_first: int
    occlusion_interval: int
    shadow_age: int
    reach_age: int
    suns_tied_from: int
    smallest_photo: float
    photos_whole_from: int
    occluders_first: int
    occluders_interval: int

    @staticmethod
    def of(settings: TrainSettings) -> "Schedule":
        """Scale the settings' milestones to their ``iterations``."""

        def own(paper_iteration: int) -> int:
            return scaled(paper_iteration, settings.iterations, settings.paper_iterations)

        density, occlusion = settings.density, settings.occlusion
        return Schedule(
            iterations=settings.iterations,
            warm_up=own(settings.warm_up),
            geometry_losses_from=own(settings.geometry_losses_from),
            densify_first=own(density.first),
            densify_last=own(density.last),
            densify_interval=own(density.interval),
            reset_interval=None if density.reset_interval is None else own(density.reset_interval),
            position_iterations=own(settings.rates.position_iterations),
            rates_fall_from=own(settings.rates.late_from),
            occlusion_first=own(occlusion.first),
            occlusion_interval=own(occlusion.interval),
            shadow_age=own(settings.daylight.shadow_age),
            reach_age=own(settings.daylight.reach_age),
            suns_tied_from=own(settings.daylight.suns_tied_from),
            smallest_photo=settings.resolution.smallest,
            photos_whole_from=own(settings.resolution.whole_from),
            occluders_first=own(settings.occluders.first),
            occluders_interval=own(settings.occluders.interval),
        )

    def photo_share(self, iteration: int) -> float:
        """Side of the photos at an iteration, as a share of their own: it grows in steps to 1."""
        if self.smallest_photo >= 1.0 or iteration >= self.photos_whole_from:
            return 1.0
        reached = iteration / self.photos_whole_from
        return max(self.smallest_photo, floor(PHOTO_STEPS * reached) / PHOTO_STEPS)

    def gaussians_share(self, iteration: int) -> float:
        """Share of the largest number of Gaussians that photos of this iteration's size are worth.

        The square of the photos' side at first and the side itself in the end: Chen et al. (2025).
        """
        share = self.photo_share(iteration)
        return (
            float(share ** (2.0 - min(iteration / self.photos_whole_from, 1.0)))
            if share < 1.0
            else 1.0
        )

    def densifies(self, iteration: int) -> bool:
        """Whether Gaussians are cloned, split and pruned after this iteration."""
        is_due = iteration % self.densify_interval == 0
        return is_due and self.densify_first <= iteration <= self.densify_last

    def densifications_left(self, iteration: int) -> int:
        """How many densifications there still are, that of this iteration included."""
        return (self.densify_last - iteration) // self.densify_interval + 1

    def holds_back_unseen(self, iteration: int) -> bool:
        """Whether unseen Gaussians are held back after this iteration: to the end of the run."""
        return iteration % self.densify_interval == 0 or iteration == self.iterations

    def finds_occluders(self, iteration: int) -> bool:
        """Whether occluders, where they are looked for, are found anew after this iteration."""
        since = iteration - self.occluders_first
        return since >= 0 and since % self.occluders_interval == 0

    def casts_shadows(self, iteration: int) -> bool:
        """Whether occlusion, where it is modelled, is cast anew after this iteration."""
        since = iteration - self.occlusion_first
        is_due = since >= 0 and since % self.occlusion_interval == 0
        return is_due or iteration == self.iterations

    def renews_light(self, iteration: int) -> bool:
        """Whether what is computed of the light is set anew before this iteration."""
        is_due = (iteration - self.occlusion_first) % self.shadow_age == 0
        return is_due and iteration >= self.occlusion_first

    def density_progress(self, iteration: int) -> float:
        """Share of the densification period that has passed, 0 to 1."""
        period = max(self.densify_last - self.densify_first, 1)
        return min(max((iteration - self.densify_first) / period, 0.0), 1.0)

    def resets_opacity(self, iteration: int) -> bool:
        """Whether opacities are reset after this iteration."""
        if self.reset_interval is None:
            return False
        is_due = iteration % self.reset_interval == 0 or iteration == self.densify_first
        return is_due and iteration < self.densify_last

    def prunes_huge(self, iteration: int) -> bool:
        """Whether too large Gaussians are pruned: after the first regular opacity reset."""
        return self.reset_interval is not None and iteration > self.reset_interval

    def position_rate(self, iteration: int, first: float, last: float) -> float:
        """Learning rate of positions: log-linear from ``first`` to ``last``, then constant."""
        share = min(iteration / self.position_iterations, 1.0)
        return exp((1 - share) * log(first) + share * log(last))

    def late_share(self, iteration: int, last: float) -> float:
        """What is left of the other rates: all at first, ``last`` in the end, log-linear."""
        late = (iteration - self.rates_fall_from) / max(self.iterations - self.rates_fall_from, 1)
        return float(last ** max(late, 0.0))
