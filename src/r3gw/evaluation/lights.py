"""Lights that a scene can be shown under: an environment map's, or one learned for a photo."""

from pathlib import Path

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError
from r3gw.gaussians.model import SceneModel
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.imaging.colour import linear_from_display
from r3gw.imaging.files import LDR_SUFFIXES
from r3gw.lighting import envmap
from r3gw.lighting.sh_rotation import rotate


def map_light(
    path: Path, degree: int, *, yaw_rad: float = 0.0, exposure: float = 1.0
) -> Float[Tensor, "coeff 3"]:
    """SH light of an environment map as it looks from inside (r3gw.lighting.envmap).

    Args:
        path: .exr or .hdr (linear), .png or .jpg (display values, made linear here).
        degree: SH degree of the model.
        yaw_rad: Turns the light about the vertical, from +z towards +x (to the map's right).
        exposure: Factor on the light.

    Raises:
        InputError: If the map is unreadable or not 2:1.
    """
    light = light_of_map(linear_env_map(path), degree)
    return exposure * rotate(light, rotation_about_axis(1, yaw_rad))


def linear_env_map(path: Path) -> Float[Tensor, "h w 3"]:
    """Read an environment map as linear light; display values (.png, .jpg) are made linear.

    Raises:
        InputError: If the map is unreadable or not 2:1.
    """
    env_map = envmap.read_env_map(path)
    return linear_from_display(env_map) if path.suffix.lower() in LDR_SUFFIXES else env_map


def light_of_map(env_map: Float[Tensor, "h w 3"], degree: int) -> Float[Tensor, "coeff 3"]:
    """SH light of a linear map that hangs as r3gw.lighting.envmap says."""
    height, width = env_map.shape[:2]
    return envmap.projected(env_map, envmap.own_weights(height, width, degree))


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
