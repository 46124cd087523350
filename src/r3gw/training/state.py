"""Everything that changes while a run trains."""

from dataclasses import dataclass, field

import torch

from r3gw.model.model import SceneModel
from r3gw.training.density import GradientStatistics
from r3gw.training.history import History
from r3gw.training.known_suns import TiedSuns
from r3gw.training.optimizer import make_optimizer
from r3gw.training.order import PhotoOrder
from r3gw.training.settings import TrainSettings
from r3gw.training.sun_shadows import SunShadows


@dataclass
class TrainingState:
    """A run in progress.

    Attributes:
        model: The scene so far.
        settings: The settings of the run.
        optimizer: Adam over the model's parameters.
        statistics: Gradient norms since the last densification.
        order: Photos left in this epoch.
        generator: Draws everything random but dropout, which draws from torch's own.
        history: Rows so far.
        sun_shadows: Shadows that were cast a short while ago.
        tied_suns: Suns that are known and move together.
        notes: What run.json should say of the run, with the iteration where it happened first.
        iteration: Iterations done.
    """

    model: SceneModel
    settings: TrainSettings
    optimizer: torch.optim.Adam
    statistics: GradientStatistics
    order: PhotoOrder
    generator: torch.Generator
    history: History
    sun_shadows: SunShadows = field(default_factory=SunShadows)
    tied_suns: TiedSuns = field(default_factory=TiedSuns)
    notes: dict[str, int] = field(default_factory=dict)
    iteration: int = 0


def first_state(model: SceneModel, settings: TrainSettings) -> TrainingState:
    """The state before the first iteration; seeds torch's own generator too, for dropout."""
    torch.manual_seed(settings.seed)
    model.appearance.dropout.p = settings.model.dropout
    return TrainingState(
        model,
        settings,
        make_optimizer(model, settings),
        GradientStatistics.of(model),
        PhotoOrder(len(model.photos)),
        torch.Generator().manual_seed(settings.seed),
        History(settings.iterations),
    )
