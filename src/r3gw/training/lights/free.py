"""Training of a free light: even at first, nowhere negative (Eq. 12)."""

from collections.abc import Iterator

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.lighting import sh
from r3gw.model.appearance import PhotoLight
from r3gw.model.light_models.free import FreeLight
from r3gw.training.first_values import first_radiance
from r3gw.training.lights.base import LightTraining, NamedLoss
from r3gw.training.losses.choice import FORMS
from r3gw.training.losses.lighting import random_directions
from r3gw.training.photos import Photo
from r3gw.training.settings import TrainSettings


def first_free(settings: TrainSettings) -> FreeLight:
    """Light of the settings' radiance from everywhere."""
    return FreeLight(sh.constant(first_radiance(settings), settings.model.light_degree))


class FreeTraining(LightTraining):
    """All there is to learn is in the MLP."""

    def losses(
        self,
        lit: PhotoLight,
        photo: Photo,  # noqa: ARG002
        settings: TrainSettings,
        generator: torch.Generator,
    ) -> Iterator[NamedLoss]:
        """Light is nowhere negative, in random directions."""
        weights, losses = settings.weights, FORMS[settings.losses]
        directions = random_directions(weights.light_directions, weights.light_domain, generator)
        directions, weight = directions.to(lit.light), weights.light
        if weights.light_average == "negative":
            weight /= max(negative_values(lit.light.detach(), directions), 1) / len(directions)
        yield NamedLoss("light", losses.positivity(lit.light, directions, weight))


def negative_values(light: Float[Tensor, "coeff 3"], directions: Float[Tensor, "m 3"]) -> int:
    """How many of the radiances in these directions are negative, channel by channel."""
    return int((sh.radiance(light, directions) < 0).sum())
