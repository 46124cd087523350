"""How a sky's radiance is spread: the CIE's clear sky, and a covered one (beyond the paper).

CIE S 011/E:2003 (ISO 15469:2004), type 12: a clear sky of low turbidity. It is brightest around the
sun and at the horizon, and darkest away from the sun, high up: where photos of a sunlit front look.
"""

from functools import lru_cache
from math import exp, pi, radians

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import UP
from r3gw.lighting import envmap
from r3gw.lighting.sun import SUN_RADIUS_DEG

# Type 12 of the standard: gradation from the horizon, and scattering around the sun.
A, B = -1.0, -0.32
C, D, E = 10.0, -3.0, 0.45
LOWEST_SINE = 0.03  # of heights above the horizon: below, the formula is 0 or undefined
QUADRATURE_ROWS = 32  # of the map that a sky is integrated on
PARTS = ("air", "haze", "covered")  # of a sky, in order: two of a clear one, and a covered one
COVERED_GRADIENT = 2.0  # the CIE's covered sky: 3 at the zenith, of 1 at the horizon


def clear_sky(
    directions: Float[Tensor, "*batch 3"], sun: Float[Tensor, "3"]
) -> Float[Tensor, "2 *batch"]:
    """Radiance of a clear sky over that of its zenith, in two parts that add up to it.

    The first is what air scatters, the blue of the sky: 1 + E cos^2 of the standard's formula,
    which has the shape of Rayleigh's phase function. The second is what haze scatters forward, the
    white glare around the sun. What is brighter still next to the sun is the sun's.

    Args:
        directions: Unit vectors above the horizon; lower ones show the horizon.
        sun: Unit vector towards the sun; a sun below the horizon counts as on it.
    """
    sine = (-directions[..., 1]).clamp_min(LOWEST_SINE)
    sun_sine = (-sun[1]).clamp(LOWEST_SINE, 1.0)
    away = torch.arccos((directions @ sun).clamp(-1.0, 1.0)).clamp_min(radians(SUN_RADIUS_DEG))
    zenith = _scattering(torch.arccos(sun_sine)).sum(dim=0) * _gradation(torch.ones_like(sun_sine))
    return _scattering(away) * _gradation(sine) / zenith


def covered_sky(directions: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch"]:
    """Radiance of the CIE's overcast sky over that of its horizon (Moon and Spencer 1942)."""
    return 1 + COVERED_GRADIENT * (-directions[..., 1]).clamp_min(0.0)


def _gradation(sine: Float[Tensor, "*batch"]) -> Float[Tensor, "*batch"]:
    return 1 + A * torch.exp(B / sine)


def _scattering(away: Float[Tensor, "*batch"]) -> Float[Tensor, "2 *batch"]:
    """By air and by haze, over angles from the sun in radians."""
    haze = C * (torch.exp(D * away) - exp(D * pi / 2))
    return torch.stack([1 + E * away.cos().square(), haze])


def skies(directions: Float[Tensor, "n 3"], sun: Float[Tensor, "3"]) -> Float[Tensor, "parts n"]:
    """Radiances of the `PARTS` of a sky in some directions."""
    return torch.cat([clear_sky(directions, sun), covered_sky(directions)[None]])


def sh_of_skies(
    sun: Float[Tensor, "3"], degree: int
) -> tuple[Float[Tensor, "parts coeff"], Float[Tensor, "parts"]]:
    """SH light of the `PARTS` of a sky (0 below the horizon), and their level irradiance.

    Args:
        sun: Unit vector towards the sun.
        degree: Highest SH band.
    """
    looks, weights, level = _upper(degree)
    shapes = skies(looks, sun.detach().to(looks))
    return shapes @ weights, shapes @ level


@lru_cache(maxsize=4)
def _upper(
    degree: int,
) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n coeff"], Float[Tensor, "n"]]:
    """Directions above the horizon, their share in each coefficient and in level irradiance."""
    looks = envmap.pixel_directions(QUADRATURE_ROWS, 2 * QUADRATURE_ROWS)
    weights = envmap.projection_weights(looks, degree)
    upper = looks[: QUADRATURE_ROWS // 2].reshape(-1, 3)
    weights = weights[: QUADRATURE_ROWS // 2].reshape(len(upper), -1)
    solid_angle = weights[:, 0] * (4 * pi) ** 0.5
    level = solid_angle * (upper @ torch.tensor(UP, dtype=upper.dtype))
    return upper.float(), weights.float(), level.float()
