"""Sun, sky and ground: outdoor light with few unknowns (beyond the paper).

The sky's radiance is smooth, SH of degree 1 above the horizon; the sun is a point; below the
horizon lies level, matt ground of one reflectance, lit by both. The SH coefficients of their sum
are linear in the sky and in the sun's power, so this light goes wherever any other SH light goes.
"""

from functools import lru_cache
from math import pi

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.lighting import envmap, sh

SKY_DEGREE = 1  # Of the sky's radiance: a mean and a gradient.
QUADRATURE_ROWS = 256  # Of the map that half-spheres are integrated on.
UP = (0.0, -1.0, 0.0)


def outdoor_light(
    sky: Float[Tensor, "4 3"],
    sun_direction: Float[Tensor, "3"],
    sun_power: Float[Tensor, "3"],
    ground_reflectance: float,
    degree: int,
) -> Float[Tensor, "coeff 3"]:
    """SH light of sky, sun and the ground that they light; differentiable.

    Args:
        sky: Radiance above the horizon, SH coefficients of degree 1.
        sun_direction: Unit vector towards the sun; below the horizon it lights no ground.
        sun_power: Irradiance of a surface that faces the sun.
        ground_reflectance: 0 to 1.
        degree: Of the result.
    """
    from_sky, from_ground, level = (part.to(sky) for part in _half_spheres(degree))
    sun = sh.basis(sun_direction, degree)[:, None] * sun_power
    height = (sun_direction * sun_direction.new_tensor(UP)).sum().clamp_min(0.0)
    ground_irradiance = level @ sky + height * sun_power
    ground = ground_reflectance / pi * ground_irradiance
    return from_sky @ sky + sun + from_ground[:, None] * ground


@lru_cache(maxsize=4)
def _half_spheres(
    degree: int,
) -> tuple[Float[Tensor, "coeff 4"], Float[Tensor, "coeff"], Float[Tensor, "4"]]:
    """What the sky's coefficients and a ground of radiance 1 add to a light; level irradiance."""
    directions = envmap.pixel_directions(QUADRATURE_ROWS, 2 * QUADRATURE_ROWS)
    weights = envmap.projection_weights(directions, degree)
    upper, lower = weights[: QUADRATURE_ROWS // 2], weights[QUADRATURE_ROWS // 2 :]
    above = directions[: QUADRATURE_ROWS // 2]
    radiance = sh.basis(above, SKY_DEGREE)
    from_sky = torch.einsum("hwk,hws->ks", upper, radiance)
    area = envmap.projection_weights(directions, 0)[: QUADRATURE_ROWS // 2, :, 0]
    area = area / sh.basis(above, 0)[..., 0]
    level = torch.einsum("hw,hws->s", area * -above[..., 1], radiance)
    return from_sky, lower.sum((0, 1)), level
