"""A photo's own exposure and white balance: three factors, one per channel, on linear values."""

from math import pi, sqrt

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.imaging.colour import GAMMA

_MIDDLE = 0.5 * sqrt(4 * pi)  # coefficient of the 0.5 that is added to a learned sky's SH


def sky_with_gains(
    coefficients: Float[Tensor, "skycoeff 3"], gains: Float[Tensor, "3"]
) -> Float[Tensor, "skycoeff 3"]:
    """A learned sky (`r3gw.lighting.skies.LearnedSky`) as a camera with ``gains`` shows it.

    Its SH are display values less 0.5, and a factor on linear values is, within the display
    curve's range, that factor to the power 1/2.2 on display values.
    """
    factors = gains ** (1 / GAMMA)
    first = coefficients[:1] * factors + _MIDDLE * (factors - 1)
    return torch.cat([first, coefficients[1:] * factors])
