"""How bright the first light and how dark the first surfaces are, as photos show them.

Photos settle the product of albedo and light alone, so both keep about the scale that they start
with. Maps at test time are read in display values (protocol ``nerf-osr``), and so are the photos
here: from above shines the sky, as bright as photos show it, from below the ground, as bright as
what stands before the sky. Training starts from an even light of the mean of both, and from the
albedo that under it looks as bright as the photos' foreground does on average.
"""

from collections.abc import Callable, Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError
from r3gw.imaging.colour import linear_from_display
from r3gw.training.losses.lighting import but_warmth
from r3gw.training.photos import Photo
from r3gw.training.settings import TrainSettings

FEWEST_PIXELS = 200  # of a kind in a photo, to count
UNSEEN_SKY = 0.7  # Mean of the skies of the embedded scenes and of Sacre-Coeur, display values.
DARKEST = 1e-4  # linear: darker photos are taken to be so dark
ALBEDO_RANGE = (0.1, 0.8)  # Of what outdoor places are made of, on average.


def first_radiance(settings: TrainSettings) -> float:
    """The settings' radiance of the first light, where it is a number by now.

    Raises:
        ValueError: If it is still to be taken from photos.
    """
    radiance = settings.init.light_radiance
    if radiance == "photos":
        raise ValueError("init.light_radiance: photos must be settled before the model is built")
    return radiance


def with_first_values(settings: TrainSettings, photos: Sequence[Photo]) -> TrainSettings:
    """The settings with radiance and albedo that the photos show where they ask for it.

    Raises:
        InputError: If they do and no photo shows any foreground.
    """
    init = settings.init
    if init.light_radiance == "photos":
        init = init.model_copy(update={"light_radiance": shown_radiance(photos)})
    if init.albedo == "photos":
        settled = settings.model_copy(update={"init": init})
        init = init.model_copy(update={"albedo": shown_albedo(photos, first_radiance(settled))})
    return settings.model_copy(update={"init": init})


def shown_radiance(photos: Sequence[Photo]) -> float:
    """Mean display value of sky (half) and foreground (half), over photos that show enough of them.

    Raises:
        InputError: If no photo shows any foreground.
    """
    skies = _photo_means(photos, of_sky=True, value=_display)
    sky = _mean(skies) if skies else UNSEEN_SKY
    foreground = _mean(_foreground_means(photos, _display))
    return round(0.5 * (sky + foreground), 4)


def shown_albedo(photos: Sequence[Photo], radiance: float) -> float:
    """Albedo that an even light of this radiance shows as bright as the foreground is (linear).

    Raises:
        InputError: If no photo shows any foreground.
    """
    linear = _foreground_means(photos, linear_from_display)
    low, high = ALBEDO_RANGE
    return round(min(max(_mean(linear) / radiance, low), high), 4)


def shown_gains(photos: Sequence[Photo], warmth: float) -> Float[Tensor, "photos 3"]:
    """Exposure and white balance by which photos of one place look alike on average.

    All photos show the same surfaces, more or less, so that how bright and of which colour their
    foreground is tells of light and camera together; nothing in a photo tells the two apart, and
    the light is taken to be alike at first.

    Args:
        photos: Of one place.
        warmth: Share of how much warmer or colder they look that is taken for the camera's.

    Returns:
        Mean linear foreground per channel, over its median over photos; 1 where a photo shows
        hardly any foreground.
    """
    shown = torch.ones(len(photos), 3)
    is_known = torch.zeros(len(photos), dtype=torch.bool)
    for row, photo in enumerate(photos):
        is_meant = ~photo.is_sky & photo.is_valid
        if int(is_meant.sum()) >= FEWEST_PIXELS:
            linear = linear_from_display(photo.planes[:, is_meant].float() / 255.0)
            shown[row] = linear.mean(dim=1).clamp_min(DARKEST)
            is_known[row] = True
    if is_known.any():
        logarithms = shown[is_known].log()
        shown[is_known] = but_warmth(logarithms - logarithms.median(dim=0).values, warmth).exp()
    return shown


def _display(pixels: torch.Tensor) -> torch.Tensor:
    return pixels


def _foreground_means(photos: Sequence[Photo], value: Callable[..., torch.Tensor]) -> list[float]:
    found = _photo_means(photos, of_sky=False, value=value)
    if not found:
        raise InputError(
            "no training photo shows anything but sky and occluders; look at the masks, or give "
            "init.light_radiance and init.albedo as numbers"
        )
    return found


def _photo_means(
    photos: Sequence[Photo], *, of_sky: bool, value: Callable[..., torch.Tensor]
) -> list[float]:
    """Mean over the valid pixels of one kind, of each photo that shows enough of them.

    Args:
        photos: One is looked at after the other, since all of them in float32 would need more
            memory than the training does.
        of_sky: Whether sky is meant, or what stands before it.
        value: What of display values ``[3, K]`` is averaged.
    """
    found = []
    for photo in photos:
        is_meant = (photo.is_sky if of_sky else ~photo.is_sky) & photo.is_valid
        if int(is_meant.sum()) >= FEWEST_PIXELS:
            found.append(float(value(photo.planes[:, is_meant].float() / 255.0).mean()))
    return found


def _mean(values: Sequence[float]) -> float:
    return float(torch.tensor(values, dtype=torch.float64).mean())
