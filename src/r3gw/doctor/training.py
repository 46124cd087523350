"""What the trainings of a scene will take: Gaussians, time, memory; does it fit this machine?"""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from r3gw.doctor.cost import Cost, predicted_cost, spoken_time
from r3gw.doctor.findings import Findings
from r3gw.gaussians.initial import load_initial
from r3gw.scene import Scene
from r3gw.settings import TrainSettings

Runs = Mapping[tuple[str, int], TrainSettings]


def describe_training(scene: Scene, initial: Path, runs: Runs, findings: Findings) -> None:
    """Predict Gaussians, time and memory of a scene's runs.

    Args:
        scene: The imported scene.
        initial: Its ``initial.npz``.
        runs: Settings by variant and seed.
        findings: Gets the facts, and a problem where memory does not suffice.
    """
    points = findings.attempt(lambda: load_initial(initial))
    train = scene.split("train")
    if points is None or not train or not runs:
        return
    foreground, sky = len(points.foreground), len(points.sky_angles)
    most = max(settings.density.max_gaussians for settings in runs.values())
    findings.facts["Gaussians"] = (
        f"start with {foreground + sky:,} ({foreground:,} foreground, {sky:,} sky), "
        f"at most {max(most, foreground + sky):,}"
    )
    pixels = [view.width * view.height for view in train]
    costs = [_cost(settings, foreground + sky, pixels) for settings in runs.values()]
    longest, largest = max(c.seconds for c in costs), max(c.memory_mb for c in costs)
    total = spoken_time(sum(cost.seconds for cost in costs))
    all_of_them = f", {total} for all {len(costs)}" if len(costs) > 1 else ""
    findings.facts["time"] = f"about {spoken_time(longest)} per training on one core{all_of_them}"
    findings.facts["memory"] = f"about {largest / 1000:.1f} GB per training"
    available = physical_memory_mb()
    if largest > available:
        findings.problems.append(
            f"{findings.title}: a training will need about {largest / 1000:.1f} GB but this "
            f"machine has {available / 1000:.1f} GB; lower 'max_image_px' or "
            "'density.max_gaussians'"
        )


def _cost(settings: TrainSettings, first: int, pixels: list[int]) -> Cost:
    last = max(first, settings.density.max_gaussians)
    return predicted_cost(
        settings.iterations, first, last, float(np.mean(pixels)), int(np.sum(pixels))
    )


def physical_memory_mb() -> float:
    """Memory of this machine in MB (10^6 bytes)."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e6
