"""Tone curves: from linear light to the values that are composited and shown.

Training composites display values (r3gw.imaging.colour), so a curve applies to every Gaussian
before compositing. `scene_linear` has no upper end: its pictures are turned back to linear light
for EXR files.
"""

from collections.abc import Callable

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.imaging.colour import DARKEST, GAMMA, display_from_linear

Curve = Callable[[Float[Tensor, "*shape"]], Float[Tensor, "*shape"]]

REINHARD_WHITE = 4.0  # linear value that becomes display white


def standard(linear: Float[Tensor, "*shape"]) -> Float[Tensor, "*shape"]:
    """Clamp and gamma, as the scene was trained."""
    return display_from_linear(linear)


def reinhard(linear: Float[Tensor, "*shape"]) -> Float[Tensor, "*shape"]:
    """Reinhard et al., "Photographic Tone Reproduction", 2002, Eq. 4, per channel, then gamma."""
    return display_from_linear(linear * (1 + linear / REINHARD_WHITE**2) / (1 + linear))


def filmic(linear: Float[Tensor, "*shape"]) -> Float[Tensor, "*shape"]:
    """Narkowicz' 2015 rational fit of the ACES film curve, per channel, then gamma."""
    above = linear * (2.51 * linear + 0.03)
    return display_from_linear(above / (linear * (2.43 * linear + 0.59) + 0.14))


def scene_linear(linear: Float[Tensor, "*shape"]) -> Float[Tensor, "*shape"]:
    """Gamma without an upper clamp; `linear_from_scene` inverts it."""
    return torch.pow(linear.clamp_min(DARKEST), 1.0 / GAMMA)


def linear_from_scene(values: Float[Tensor, "*shape"]) -> Float[Tensor, "*shape"]:
    """Invert `scene_linear` on a composited picture."""
    return torch.pow(values, GAMMA)


CURVES: dict[str, Curve] = {"standard": standard, "reinhard": reinhard, "filmic": filmic}
