"""Which training belongs to which light model."""

from collections.abc import Mapping

from r3gw.model.light_models.base import LightModel
from r3gw.model.light_models.fixed import FixedLight
from r3gw.model.light_models.free import FreeLight
from r3gw.model.light_models.outdoor import OutdoorLight
from r3gw.training.lights.base import LightTraining, Seen
from r3gw.training.lights.fixed import FixedTraining
from r3gw.training.lights.free import FreeTraining
from r3gw.training.lights.outdoor import OutdoorTraining
from r3gw.training.settings import TrainSettings

TRAININGS: Mapping[type[LightModel], LightTraining] = {
    FreeLight: FreeTraining(),
    OutdoorLight: OutdoorTraining(),
    FixedLight: FixedTraining(),
}


def first_light(settings: TrainSettings, seen: Seen) -> LightModel:
    """The light model that the settings ask for, before training.

    Args:
        settings: Of the run.
        seen: Per embedding, the skies that its photos show.
    """
    kind = OutdoorLight if settings.outdoor.enabled else FreeLight
    return TRAININGS[kind].first(settings, seen)


def training_of(light_model: LightModel) -> LightTraining:
    """How a light model is trained."""
    return TRAININGS[type(light_model)]
