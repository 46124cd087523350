"""How bright the first light is, from what the training photos show (beyond the paper).

Photos settle the product of albedo and light alone, so the light keeps about the scale that it
starts with. Maps at test time are read in display values (protocol ``nerf-osr``), and so are the
photos here: from above shines the sky, as bright as photos show it, from below the ground, as
bright as what stands before the sky. Training starts from an even light of the mean of both. The
paper does not say what it starts from.
"""

from collections.abc import Sequence

import torch

from r3gw.files import InputError
from r3gw.training.photos import Photo
from r3gw.training.settings import TrainSettings

FEWEST_PIXELS = 200  # of a kind in a photo, to count
UNSEEN_SKY = 0.7  # Mean of the skies of the embedded scenes and of Sacre-Coeur, display values.


def first_radiance(settings: TrainSettings) -> float:
    """The settings' radiance of the first light, where it is a number by now.

    Raises:
        ValueError: If it is still to be taken from photos.
    """
    radiance = settings.init.light_radiance
    if radiance == "photos":
        raise ValueError("init.light_radiance: photos must be settled before the model is built")
    return radiance


def with_shown_light(settings: TrainSettings, photos: Sequence[Photo]) -> TrainSettings:
    """The settings with the radiance that the photos show where they ask for it."""
    if settings.init.light_radiance != "photos":
        return settings
    init = settings.init.model_copy(update={"light_radiance": shown_radiance(photos)})
    return settings.model_copy(update={"init": init})


def shown_radiance(photos: Sequence[Photo]) -> float:
    """Mean display value of sky (half) and foreground (half), over photos that show enough of them.

    Raises:
        InputError: If no photo shows any foreground.
    """
    skies: list[float] = []
    foregrounds: list[float] = []
    for photo in photos:
        brightness = photo.planes.float().mean(dim=0) / 255.0
        for found, mask in ((skies, photo.is_sky), (foregrounds, ~photo.is_sky)):
            shown = brightness[mask & photo.is_valid]
            if len(shown) >= FEWEST_PIXELS:
                found.append(float(shown.mean()))
    if not foregrounds:
        raise InputError(
            "no training photo shows anything but sky and occluders; look at the masks, or give "
            "init.light_radiance as a number"
        )
    sky = _mean(skies) if skies else UNSEEN_SKY
    return round(0.5 * (sky + _mean(foregrounds)), 4)


def _mean(values: Sequence[float]) -> float:
    return float(torch.tensor(values, dtype=torch.float64).mean())
