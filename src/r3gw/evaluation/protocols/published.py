"""The light of a test view by the NeRF-OSR protocol: the session's map, mirrored and turned."""

from functools import lru_cache

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.files import InputError
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.lighting import envmap
from r3gw.lighting.light import Light
from r3gw.lighting.maps import linear_env_map
from r3gw.lighting.sun import sun_of_map
from r3gw.scene import EvaluationEntry, View


def published_light(
    evaluated: EvaluatedScene, view: View, entry: EvaluationEntry, *, is_linear: bool = False
) -> Light:
    """Light of the view's LDR map at sun angle 0 (`r3gw.lighting.envmap.published_directions`).

    Args:
        evaluated: Gives the scene's folder and the light's degree.
        view: Named in errors.
        entry: Map, initial rotation, threshold and scale.
        is_linear: Whether display values are made linear, as the published protocol does not. The
            threshold is one of the file's values either way.

    Raises:
        InputError: If the map is unreadable or black, or its initial rotation is not about x alone.
    """
    path = evaluated.scene_folder / entry.env_map
    given = envmap.read_env_map(path)
    if not given.any():
        raise InputError(f"{path}: is black, so view '{view.name}' has no light; replace the map")
    light = linear_env_map(path) if is_linear else given
    bright = torch.where(given > entry.threshold, light * entry.scale, light)
    height, width = bright.shape[:2]
    turn_rad = published_turn_rad(view, entry)
    coefficients = envmap.projected(
        bright, _weights(height, width, turn_rad, evaluated.light_degree)
    )
    looks = envmap.published_directions(height, width, turn_rad, 0.0)
    return Light(coefficients, point=sun_of_map(bright, looks))


@lru_cache(maxsize=2)
def _weights(
    height: int, width: int, turn_rad: float, degree: int
) -> Float[Tensor, "{height} {width} coeff"]:
    """Kept, because the maps of a scene are alike."""
    directions = envmap.published_directions(height, width, turn_rad, 0.0)
    return envmap.projection_weights(directions, degree)


def published_turn_rad(view: View, entry: EvaluationEntry) -> float:
    """Initial rotation of the view's map, about x.

    Raises:
        InputError: If it turns about y or z, for which no published order exists.
    """
    x, y, z = entry.rotation_rad
    if y != 0 or z != 0:
        raise InputError(
            f"view '{view.name}': initial_env_map_rotation has y={y:g} and z={z:g}; the published "
            "protocol turns about x alone, so set both to 0 and widen sun_angles instead"
        )
    return x


def at_sun_angle(light: Light, angle_rad: float) -> Light:
    """Turn a published light from sun angle 0 to ``angle_rad``: about the vertical, exactly."""
    return light.rotated(rotation_about_axis(1, -angle_rad))
