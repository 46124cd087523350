"""Training of sun, sky and ground (beyond the paper): near what photos show of the sky.

Its losses stand in for the positivity loss: a point sun in SH of degree 4 is negative in places.
"""

from collections.abc import Iterator

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.model.appearance import PhotoLight
from r3gw.model.light_models.base import OpenSky
from r3gw.model.light_models.outdoor import OutdoorLight
from r3gw.training.first_values import first_radiance
from r3gw.training.lights.base import NamedLoss, Seen, SunTraining
from r3gw.training.losses.lighting import visible_sky_loss
from r3gw.training.photos import Photo
from r3gw.training.settings import OutdoorSettings, TrainSettings
from r3gw.training.visible_sky import first_sky


def first_outdoor(settings: TrainSettings, seen: Seen) -> OutdoorLight:
    """Skies as the photos show them, per embedding, and a sun overhead."""
    outdoor, otherwise = settings.outdoor, first_radiance(settings)
    skies = torch.stack([first_sky(photos, otherwise) for photos in seen])
    return OutdoorLight(
        skies, outdoor.sun_power, outdoor.ground_reflectance, settings.model.light_degree
    )


class OutdoorTraining(SunTraining):
    """Direction and power of the sun are learned beside the MLP."""

    def losses(
        self,
        lit: PhotoLight,
        photo: Photo,
        settings: TrainSettings,
        generator: torch.Generator,  # noqa: ARG002
    ) -> Iterator[NamedLoss]:
        """The photo's sky is as bright as the photo shows it, its gradient near the first."""
        assert isinstance(lit.open_sky, OpenSky)  # an OutdoorLight gives it
        yield NamedLoss("light", open_sky_loss(lit.open_sky, photo, settings.outdoor))


def open_sky_loss(open_sky: OpenSky, photo: Photo, settings: OutdoorSettings) -> Float[Tensor, ""]:
    """What keeps the sky near what its photo shows, its gradient near the first."""
    steady = settings.sky_gradient * open_sky.change[1:].square().sum()
    if photo.seen_sky is None:
        return steady
    seen = photo.seen_sky
    return steady + settings.visible_sky * visible_sky_loss(
        open_sky.radiance, seen.basis, seen.radiance, seen.is_clipped
    )
