"""What training must know of every light model."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import torch

from r3gw.model.appearance import PhotoLight
from r3gw.model.light_models.base import LightModel
from r3gw.training.losses.weighted import Weighted
from r3gw.training.photos import Photo
from r3gw.training.settings import TrainSettings
from r3gw.training.visible_sky import VisibleSky

Seen = Sequence[Sequence[VisibleSky]]


class NamedLoss(NamedTuple):
    """A weighted loss and its column in history.csv."""

    name: str
    loss: Weighted


class LightTraining:
    """The training of one kind of light model; here nothing of it is learned or held back.

    A new kind is a row of `r3gw.training.lights.kinds`.
    """

    def rate(self, settings: TrainSettings) -> float:  # noqa: ARG002
        """Learning rate of the light model's own parameters; the MLP has its own."""
        return 0.0

    def renew(self, light_model: LightModel, seen: Seen) -> None:
        """Set anew what is computed of a light model and not learned, every now and then.

        Args:
            light_model: Changed in place.
            seen: For each embedding, the skies that its photos show.
        """

    def losses(
        self,
        lit: PhotoLight,  # noqa: ARG002
        photo: Photo,  # noqa: ARG002
        settings: TrainSettings,  # noqa: ARG002
        generator: torch.Generator,  # noqa: ARG002
    ) -> Iterator[NamedLoss]:
        """What keeps the light of a photo plausible.

        Args:
            lit: The photo's light, without noise.
            photo: The photo.
            settings: The settings of the run; the losses come weighted by them.
            generator: Draws what is random.
        """
        yield from ()


class SunTraining(LightTraining):
    """The training of a light model with a sun: its direction and power are learned."""

    def rate(self, settings: TrainSettings) -> float:
        """The sun's, faster in short runs."""
        return settings.outdoor.sun_rate * settings.rates.short_run_boost
