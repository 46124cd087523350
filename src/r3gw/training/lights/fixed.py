"""Training under known lights: nothing about them is learned."""

from r3gw.model.light_models.base import LightModel
from r3gw.training.lights.base import LightTraining, Seen
from r3gw.training.settings import TrainSettings


class FixedTraining(LightTraining):
    """No losses; the lights are given to `r3gw.training.start.initial_model`."""

    def first(self, settings: TrainSettings, seen: Seen) -> LightModel:
        """No settings ask for known lights."""
        raise ValueError("known lights are given to initial_model, not made from settings")
