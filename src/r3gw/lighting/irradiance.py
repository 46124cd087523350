"""Irradiance of a surface under SH light: the cosine lobe of Ramamoorthi and Hanrahan (2001)."""

from math import isqrt, pi

from jaxtyping import Float
from torch import Tensor

from r3gw.lighting import sh

# Factor of bands 0, 1, 2 of a clamped cosine; higher bands are left out (paper, Eq. 6).
COSINE_BANDS = (pi, 2 * pi / 3, pi / 4)
DARKEST_IRRADIANCE = 1e-4


def irradiance(
    light: Float[Tensor, "coeff 3"], normals: Float[Tensor, "n 3"]
) -> Float[Tensor, "n 3"]:
    """Irradiance E(n) from bands 0 to 2 of ``light``, at least 1e-4.

    Args:
        light: SH coefficients of the environment light, any degree.
        normals: Unit vectors.
    """
    count = min(light.shape[0], 9)
    factors = light.new_tensor([COSINE_BANDS[isqrt(i)] for i in range(count)])
    values = sh.radiance(light[:count] * factors[:, None], normals)
    return values.clamp_min(DARKEST_IRRADIANCE)
