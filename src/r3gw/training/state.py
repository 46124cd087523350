"""Everything that changes while a run trains, and its checkpoint.

A checkpoint lies beside the run, under a name with the digest of its settings. It is no declared
output of the workflow (Snakemake deletes those of interrupted jobs) and goes when training ends.
A run that continues from one gives the same bytes as a run that was never interrupted.
"""

import logging
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from r3gw.files import atomic_path
from r3gw.files.provenance import digest
from r3gw.model.model import SceneModel, model_content, model_from
from r3gw.training.density import GradientStatistics
from r3gw.training.history import History
from r3gw.training.optimizer import make_optimizer
from r3gw.training.order import PhotoOrder

log = logging.getLogger(__name__)


@dataclass
class TrainingState:
    """A run in progress.

    Attributes:
        model: The scene so far.
        optimizer: Adam over the model's parameters.
        statistics: Gradient norms since the last densification.
        order: Photos left in this epoch.
        generator: Draws everything random but dropout, which draws from torch's own.
        history: Rows so far.
        iteration: Iterations done.
    """

    model: SceneModel
    optimizer: torch.optim.Adam
    statistics: GradientStatistics
    order: PhotoOrder
    generator: torch.Generator
    history: History
    iteration: int = 0


def first_state(model: SceneModel) -> TrainingState:
    """The state before the first iteration; seeds torch's own generator too, for dropout."""
    seed = model.settings.seed
    torch.manual_seed(seed)
    return TrainingState(
        model,
        make_optimizer(model),
        GradientStatistics(model.num_gaussians),
        PhotoOrder(len(model.photos)),
        torch.Generator().manual_seed(seed),
        History(model.settings.iterations),
    )


class Checkpoints:
    """Saves a run every ``interval_s`` seconds and finds it again."""

    def __init__(self, folder: Path, model: SceneModel, interval_s: float = 300.0) -> None:
        """Keep the checkpoint of ``model``'s settings in ``folder``."""
        name = digest(model.settings.model_dump(mode="json"))
        self.path = folder / f".checkpoint-{name}.pt"
        self.interval_s = interval_s
        self._last = time.monotonic()

    def restore(self, state: TrainingState) -> TrainingState:
        """The saved state if there is one for the same photos, else ``state``."""
        if not self.path.is_file():
            return state
        saved: dict[str, Any] = torch.load(self.path, weights_only=True)
        if tuple(saved["model"]["photos"]) != state.model.photos:
            log.warning("%s is of other photos: starting afresh", self.path)
            return state
        log.info("continuing from %s at iteration %d", self.path, saved["iteration"])
        model = model_from(saved["model"])
        restored = first_state(model)
        restored.optimizer.load_state_dict(saved["optimizer"])
        restored.statistics.total, restored.statistics.views = saved["statistics"]
        restored.order.left = saved["order"]
        restored.generator.set_state(saved["generator"])
        torch.set_rng_state(saved["dropout"])
        restored.history.resume(saved["history"], saved["seconds"])
        restored.iteration = saved["iteration"]
        return restored

    def save_if_due(self, state: TrainingState) -> None:
        """Write the state if the last checkpoint is old enough."""
        if time.monotonic() - self._last < self.interval_s:
            return
        content = {
            "model": model_content(state.model),
            "optimizer": state.optimizer.state_dict(),
            "statistics": [state.statistics.total, state.statistics.views],
            "order": state.order.left,
            "generator": state.generator.get_state(),
            "dropout": torch.get_rng_state(),
            "history": state.history.rows,
            "seconds": state.history.seconds(),
            "iteration": state.iteration,
        }
        with atomic_path(self.path) as temporary:
            torch.save(content, temporary)
        self._last = time.monotonic()

    def discard(self) -> None:
        """Remove the checkpoint: the run is complete."""
        self.path.unlink(missing_ok=True)
