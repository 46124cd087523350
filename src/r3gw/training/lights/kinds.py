"""Which training belongs to which light model, and which one the settings ask for."""

from collections.abc import Mapping, Sequence

from r3gw.model.appearance import Appearance
from r3gw.model.light_models.base import LightModel
from r3gw.model.light_models.daylight import Daylight
from r3gw.model.light_models.fixed import FixedLight
from r3gw.model.light_models.free import FreeLight
from r3gw.model.light_models.outdoor import OutdoorLight
from r3gw.training.known_suns import Suns
from r3gw.training.lights.base import LightTraining, Seen
from r3gw.training.lights.daylight import DaylightTraining, first_daylight
from r3gw.training.lights.free import FreeTraining, first_free
from r3gw.training.lights.outdoor import OutdoorTraining, first_outdoor
from r3gw.training.settings import TrainSettings
from r3gw.training.visible_sky import VisibleSky, seen_by_row

TRAININGS: Mapping[type[LightModel], LightTraining] = {
    FreeLight: FreeTraining(),
    OutdoorLight: OutdoorTraining(),
    Daylight: DaylightTraining(),
    FixedLight: LightTraining(),  # nothing about known lights is learned
}


def first_light(settings: TrainSettings, seen: Seen, suns: Suns = ()) -> LightModel:
    """The light model that the settings ask for, before training.

    Args:
        settings: The settings of the run.
        seen: For each embedding, the skies that its photos show.
        suns: For each embedding, its sun if that is known (r3gw.training.known_suns).
    """
    if settings.daylight.enabled:
        return first_daylight(settings, seen, suns)
    if settings.outdoor.enabled:
        return first_outdoor(settings, seen)
    return first_free(settings)


def training_of(light_model: LightModel) -> LightTraining:
    """How a light model is trained."""
    return TRAININGS[type(light_model)]


def renew_light(appearance: Appearance, seen_skies: Sequence[VisibleSky | None]) -> None:
    """Set anew what is computed of a light and not learned.

    Args:
        appearance: Holds the light model; changed in place.
        seen_skies: What each photo shows of its sky, if any.
    """
    light_model = appearance.light_model
    training_of(light_model).renew(light_model, seen_by_row(appearance.rows, seen_skies))
