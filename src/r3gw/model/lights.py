"""The lights that a model learned for its photos."""

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError
from r3gw.model.model import SceneModel


@torch.no_grad()
def photo_light(
    model: SceneModel, photo: str
) -> tuple[Float[Tensor, "coeff 3"], Float[Tensor, "skycoeff 3"]]:
    """Light and sky coefficients that were learned for a training photo.

    Raises:
        InputError: If the model was not trained on the photo.
    """
    if photo not in model.photos:
        known = ", ".join(model.photos)
        raise InputError(f"the model has no light of a photo '{photo}'; it was trained on: {known}")
    light, sky, _ = model.appearance(model.photos.index(photo))
    return light, sky


def learned_strength(model: SceneModel) -> float:
    """Mean over photos and channels of the coefficient of band 0 of the learned lights."""
    lights = [photo_light(model, photo)[0] for photo in model.photos]
    return float(torch.stack(lights)[:, 0].mean())
