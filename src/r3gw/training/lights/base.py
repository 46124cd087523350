"""What training must know of every light model."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.model.appearance import PhotoLight
from r3gw.model.light_models.base import LightModel
from r3gw.training.losses.known_gradient import KnownLoss
from r3gw.training.photos import Photo
from r3gw.training.settings import TrainSettings
from r3gw.training.visible_sky import VisibleSky

Seen = Sequence[Sequence[VisibleSky]]
Loss = KnownLoss | Float[Tensor, ""]


class NamedLoss(NamedTuple):
    """A weighted loss and its column in history.csv."""

    name: str
    loss: Loss


class LightTraining(ABC):
    """The training of one kind of light model. A new kind is a row of `r3gw.training.lights.kinds`."""

    @abstractmethod
    def first(self, settings: TrainSettings, seen: Seen) -> LightModel:
        """The light model before training.

        Args:
            settings: Of the run.
            seen: Per embedding, the skies that its photos show.
        """

    def rate(self, settings: TrainSettings) -> float:  # noqa: ARG002
        """Learning rate of the light model's own parameters; the MLP has its own."""
        return 0.0

    def losses(
        self,
        lit: PhotoLight,  # noqa: ARG002
        photo: Photo,  # noqa: ARG002
        settings: TrainSettings,  # noqa: ARG002
        generator: torch.Generator,  # noqa: ARG002
    ) -> Iterator[NamedLoss]:
        """What keeps the light of a photo plausible; by default nothing.

        Args:
            lit: The photo's light, without noise.
            photo: The photo.
            settings: Of the run; the losses come weighted.
            generator: Draws what is random.
        """
        yield from ()
