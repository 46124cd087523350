"""The model that a training starts from."""

from collections.abc import Sequence

import torch

from r3gw.lighting import sh
from r3gw.model.appearance import Appearance
from r3gw.model.description import ModelDescription, light_rows
from r3gw.model.foreground import initial_foreground
from r3gw.model.initial import InitialPoints
from r3gw.model.light_models.base import LightModel
from r3gw.model.model import SceneModel
from r3gw.model.rows import OCCLUSION
from r3gw.model.sky import initial_sky
from r3gw.training.first_values import shown_gains
from r3gw.training.known_suns import Suns, suns_by_row
from r3gw.training.lights.kinds import first_light
from r3gw.training.photos import Photo
from r3gw.training.settings import TrainSettings
from r3gw.training.visible_sky import VisibleSky, seen_by_row, without_gains


def model_of_photos(
    initial: InitialPoints,
    photos: Sequence[Photo],
    settings: TrainSettings,
    sessions: tuple[str, ...] | None = None,
) -> SceneModel:
    """Build the model that training on photos starts from, as these show lights and cameras.

    Args:
        initial: Points of both sets.
        photos: The training photos.
        settings: The settings of the run, with first values (r3gw.training.first_values).
        sessions: The photos' sessions; by default each photo is a session of its own.
    """
    gains = torch.ones(len(photos), 3)
    if settings.gains.enabled:
        gains = shown_gains(photos, settings.gains.warmth)
    skies = without_gains([photo.seen_sky for photo in photos], gains)
    names = tuple(photo.name for photo in photos)
    suns = [photo.known_sun for photo in photos]
    model = initial_model(initial, names, settings, sessions, skies, suns=suns)
    model.appearance.set_gains(gains)
    return model


def initial_model(
    initial: InitialPoints,
    photos: tuple[str, ...],
    settings: TrainSettings,
    sessions: tuple[str, ...] | None = None,
    seen: Sequence[VisibleSky | None] = (),
    light_model: LightModel | None = None,
    suns: Suns = (),
) -> SceneModel:
    """Build the model that training starts from.

    Args:
        initial: Points of both sets.
        photos: Names of the training photos.
        settings: The settings of the run.
        sessions: The photos' sessions; by default each photo is a session of its own.
        seen: What each photo shows of its sky, if any.
        light_model: The light model to use; None takes the one that the settings ask for.
        suns: The sun of each photo, if it is known (r3gw.training.known_suns).
    """
    sessions = photos if sessions is None else sessions
    generator = torch.Generator().manual_seed(settings.seed)
    dome, points, angles = initial.dome, initial.foreground, initial.sky_angles
    if not settings.model.separate_sky:
        points = torch.cat([points, initial.sky_points()])
        angles = angles[:0]
    rows = light_rows(sessions, settings.model.share_session_light)
    if light_model is None:
        light_model = first_light(settings, seen_by_row(rows, seen), suns_by_row(rows, suns))
    description = _description(settings, light_model)
    foreground = initial_foreground(points, settings.init)
    if settings.occlusion.enabled:
        size = sh.num_coefficients(description.light_degree)
        foreground.add_computed(OCCLUSION, torch.zeros(len(points), size))
    sky = initial_sky(dome, angles, settings.init)
    sky.keep_opaque(settings.sky.least_opacity)
    return SceneModel(
        description,
        foreground,
        sky,
        Appearance(rows, description, light_model, generator),
        photos,
        sessions,
    )


def _description(settings: TrainSettings, light_model: LightModel) -> ModelDescription:
    """What settings and light make of a model."""
    model = settings.model
    return ModelDescription.model_validate(
        {
            "separate_sky": model.separate_sky,
            "specular": model.specular,
            "share_session_light": model.share_session_light,
            "photo_gains": settings.gains.enabled,
            "light": light_model.describe(),
            "embedding_size": model.embedding_size,
            "hidden_size": model.hidden_size,
            "light_hidden_size": model.light_hidden_size,
        }
    )
