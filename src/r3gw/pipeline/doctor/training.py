"""What the trainings of a scene will take: Gaussians, time, memory; does it fit this machine?

Loads no PyTorch, so that looking at a run costs a fraction of a second.
"""

import os
from collections.abc import Sequence
from pathlib import Path

from pydantic import Field

from r3gw.files import InputError
from r3gw.files.strict import Strict, read_yaml, validated
from r3gw.pipeline.doctor.cost import Cost, predicted_cost, shadows_cost, spoken_time
from r3gw.pipeline.doctor.findings import Findings
from r3gw.training.schedule import smaller_photos_share
from r3gw.training.settings import TrainSettings


class SceneSize(Strict):
    """What of a scene decides the cost of its trainings.

    Attributes:
        foreground, sky: How many Gaussians of each set training starts with.
        photos: How many training photos there are.
        photo_pixels: Pixels of all training photos together.
    """

    foreground: int = Field(ge=0)
    sky: int = Field(ge=0)
    photos: int = Field(gt=0)
    photo_pixels: int = Field(gt=0)

    @property
    def gaussians(self) -> int:
        """Initial Gaussians."""
        return self.foreground + self.sky


def read_size(record: Path) -> SceneSize:
    """Size of a scene from the record that ``doctor-scene`` wrote.

    Raises:
        InputError: If the record is missing or holds no size.
    """
    content = read_yaml(record)
    if "size" not in content:
        raise InputError(f"{record}: holds no size of the scene; run doctor-scene again")
    return validated(SceneSize, content["size"], str(record))


def describe_training(size: SceneSize, runs: Sequence[TrainSettings], findings: Findings) -> None:
    """Predict Gaussians, time and memory of a scene's runs.

    Args:
        size: How large the scene is.
        runs: Settings of each run, at least one.
        findings: Gets the facts, and a problem where memory does not suffice.
    """
    first = size.gaussians
    most = max(settings.density.max_gaussians for settings in runs)
    findings.facts["Gaussians"] = (
        f"start with {first:,} ({size.foreground:,} foreground, {size.sky:,} sky), "
        f"at most {max(most, first):,}"
    )
    costs = [predicted(settings, size) for settings in runs]
    least = [predicted_with(settings, size, first) for settings in runs]
    largest = max(cost.memory_mb for cost in costs)
    each = _spoken_range(max(c.seconds for c in least), max(c.seconds for c in costs))
    total = _spoken_range(sum(c.seconds for c in least), sum(c.seconds for c in costs))
    all_of_them = f", {total} for all {len(costs)}" if len(costs) > 1 else ""
    findings.facts["time"] = (
        f"{each} per training on one core, as the Gaussians stay few or grow to their most"
        f"{all_of_them}"
    )
    findings.facts["memory"] = f"up to {largest / 1000:.1f} GB per training"
    available = physical_memory_mb()
    if largest > available:
        findings.problems.append(
            f"{findings.title}: a training will need about {largest / 1000:.1f} GB but this "
            f"machine has {available / 1000:.1f} GB; lower 'max_image_px' or "
            "'density.max_gaussians'"
        )


def _spoken_range(least_s: float, most_s: float) -> str:
    """Two durations for people, one where both are said alike."""
    least, most = spoken_time(least_s), spoken_time(most_s)
    return f"about {most}" if least == most else f"{least} to {most}"


def predicted(settings: TrainSettings, size: SceneSize) -> Cost:
    """Time and memory of one training of a scene whose Gaussians grow to their largest number."""
    return predicted_with(settings, size, max(size.gaussians, settings.density.max_gaussians))


def predicted_with(settings: TrainSettings, size: SceneSize, last: int) -> Cost:
    """Time and memory of one training of a scene that ends with ``last`` Gaussians."""
    pixels = size.photo_pixels / size.photos
    kept = round(size.photo_pixels * (1 + smaller_photos_share(settings)))
    plain = predicted_cost(settings.iterations, size.gaussians, last, pixels, kept)
    shadows = settings.occlusion
    if not shadows.enabled:
        return plain
    casts = 1 + max(0, settings.paper_iterations - shadows.first) / shadows.interval
    more = shadows_cost(casts, shadows.directions, 0.5 * (size.gaussians + last), last)
    return Cost(plain.seconds + more.seconds, plain.memory_mb + more.memory_mb)


def physical_memory_mb() -> float:
    """Memory of this machine in MB (10^6 bytes)."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e6
