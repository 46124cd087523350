"""The training loop of one run: a scene, resolved settings, a seed."""

import logging
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import torch
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.gaussians.density import (
    GradientStatistics,
    densify,
    reset_opacity,
    rising_threshold,
)
from r3gw.gaussians.initial import load_initial
from r3gw.gaussians.model import SceneModel, initial_model
from r3gw.scene import load_scene
from r3gw.settings import TrainSettings
from r3gw.training.history import History
from r3gw.training.objective import objective
from r3gw.training.optimizer import make_optimizer, set_position_rate
from r3gw.training.photos import Photo, camera_extent, load_photos
from r3gw.training.schedule import Schedule

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Trained:
    """Result of a training: the model, its history and how long it took."""

    model: SceneModel
    history: History
    seconds: float


def train_scene(
    scene_folder: Path, masks_folder: Path, initial_path: Path, settings: TrainSettings
) -> Trained:
    """Train one scene.

    Raises:
        InputError: If inputs are missing or malformed, or the loss stops being finite.
    """
    photos = load_photos(load_scene(scene_folder), scene_folder, masks_folder)
    names = tuple(photo.name for photo in photos)
    model = initial_model(load_initial(initial_path), names, settings)
    return train(model, photos)


def train(model: SceneModel, photos: list[Photo]) -> Trained:
    """Optimise ``model`` on ``photos`` for the iterations that its settings name."""
    settings = model.settings
    schedule = Schedule.of(settings)
    torch.manual_seed(settings.seed)  # dropout draws from the global generator
    generator = torch.Generator().manual_seed(settings.seed)
    optimizer = make_optimizer(model)
    extent = camera_extent([photo.camera for photo in photos])
    statistics = GradientStatistics(model.num_gaussians)
    history = History(settings.iterations)
    order = _shuffled(len(photos), generator)
    model.appearance.train()
    start = time.perf_counter()
    quiet_s = 0.1 if sys.stderr.isatty() else 10.0
    with tqdm(total=settings.iterations, desc="train", mininterval=quiet_s) as bar:
        for iteration in range(1, settings.iterations + 1):
            set_position_rate(optimizer, model, schedule, iteration)
            index = next(order)
            photo = photos[index]
            rendering, parts = objective(model, photo, index, iteration, schedule, generator)
            loss = torch.stack(list(parts.values())).sum()
            if not torch.isfinite(loss):
                raise InputError(_not_finite(iteration, photo, parts))
            optimizer.zero_grad(set_to_none=True)
            torch.autograd.backward(loss)
            if iteration <= schedule.densify_last and rendering.means2d.grad is not None:
                camera = photo.camera
                statistics.add(
                    rendering.means2d.grad, rendering.radii_px, camera.width, camera.height
                )
            optimizer.step()
            model.sky.clamp_to_dome()
            if _change_density(
                model, optimizer, schedule, statistics, iteration, extent, generator
            ):
                statistics = GradientStatistics(model.num_gaussians)
            if history.is_due(iteration):
                row = history.add(iteration, model, photo, rendering, parts)
                bar.set_postfix_str(_postfix(row), refresh=False)
            bar.update()
    model.appearance.eval()
    return Trained(model, history, time.perf_counter() - start)


def _change_density(
    model: SceneModel,
    optimizer: torch.optim.Optimizer,
    schedule: Schedule,
    statistics: GradientStatistics,
    iteration: int,
    extent: float,
    generator: torch.Generator,
) -> bool:
    """Densify and reset opacities if due; return whether the Gaussians changed in number."""
    density = model.settings.density
    is_due = schedule.densifies(iteration)
    if is_due:
        densify(
            model,
            optimizer,
            statistics.mean(),
            threshold=rising_threshold(
                schedule.density_progress(iteration),
                density.threshold_first,
                density.threshold_last,
            ),
            extent=extent,
            prune_huge=schedule.prunes_huge(iteration),
            generator=generator,
        )
        if len(model.foreground) == 0:
            raise InputError(
                f"training lost all foreground Gaussians at iteration {iteration}; check the "
                "masks (polarity, coverage) and the learning rates"
            )
    if schedule.resets_opacity(iteration):
        reset_opacity(model, optimizer)
    return is_due


def _shuffled(count: int, generator: torch.Generator) -> Iterator[int]:
    """Yield photo indices forever, each epoch in a new random order."""
    while True:
        yield from torch.randperm(count, generator=generator).tolist()


def _postfix(row: dict[str, float | int]) -> str:
    return (
        f"loss {row['loss']:.4f}  psnr {row['psnr']:.2f} dB  "
        f"{row['num_foreground']:.0f} foreground + {row['num_sky']:.0f} sky"
    )


def _not_finite(iteration: int, photo: Photo, parts: dict[str, torch.Tensor]) -> str:
    bad = ", ".join(name for name, part in parts.items() if not torch.isfinite(part))
    return (
        f"training diverged at iteration {iteration} on photo {photo.name}: the loss part(s) "
        f"{bad} are not finite; lower the learning rates or rates.short_run_boost"
    )
