"""The lights that a model learned for its photos."""

import torch

from r3gw.files import InputError
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.model.model import SceneModel


@torch.no_grad()
def photo_light(model: SceneModel, photo: str) -> Light:
    """The light and the sky that were learned for a training photo, without its camera's gains.

    Raises:
        InputError: If the model was not trained on the photo.
    """
    lit = model.appearance.scene_light(_index(model, photo))
    return Light(lit.light, LearnedSky(lit.sky_light), lit.sun)


@torch.no_grad()
def photographed_light(model: SceneModel, photo: str) -> Light:
    """A training photo's light and sky in its own units: with its exposure and white balance.

    Raises:
        InputError: If the model was not trained on the photo.
    """
    lit = model.appearance(_index(model, photo))
    return Light(lit.light, LearnedSky(lit.sky_light), lit.sun)


def _index(model: SceneModel, photo: str) -> int:
    if photo not in model.photos:
        known = ", ".join(model.photos)
        raise InputError(f"the model has no light of a photo '{photo}'; it was trained on: {known}")
    return model.photos.index(photo)


def learned_lights(model: SceneModel) -> dict[str, Light]:
    """The lights of all training photos, by the photo's name."""
    return {photo: photo_light(model, photo) for photo in model.photos}


def learned_strength(model: SceneModel) -> float:
    """Mean over photos and channels of the coefficient of band 0 of the learned lights."""
    lights = [light.sh for light in learned_lights(model).values()]
    return float(torch.stack(lights)[:, 0].mean())
