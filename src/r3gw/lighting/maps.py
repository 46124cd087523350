"""SH light of an environment map's file."""

from pathlib import Path

from jaxtyping import Float
from torch import Tensor

from r3gw.imaging.colour import linear_from_display
from r3gw.imaging.files import LDR_SUFFIXES
from r3gw.lighting import envmap


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
