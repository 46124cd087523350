"""Sun, sky and ground: outdoor light with few unknowns (beyond the paper).

The sky's radiance is smooth, SH of degree 1 above the horizon; the sun is a point; below the
horizon lies level, matt ground of one reflectance, lit by both. The SH coefficients of their sum
are linear in the sky and in the sun's power, so this light goes wherever any other SH light goes.
"""

from functools import lru_cache
from math import pi, sqrt

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import UP
from r3gw.lighting import envmap, sh

SKY_DEGREE = 1  # Of the sky's radiance: a mean and a gradient.
QUADRATURE_ROWS = 256  # Of the map that half-spheres are integrated on.


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
        degree: SH degree of the light that comes out.
    """
    from_sky, from_ground, level = (part.to(sky) for part in _half_spheres(degree))
    sun = basis_of_one(sun_direction, degree)[:, None] * sun_power
    height = (sun_direction * sun_direction.new_tensor(UP)).sum().clamp_min(0.0)
    ground_irradiance = level @ sky + height * sun_power
    ground = ground_reflectance / pi * ground_irradiance
    return from_sky @ sky + sun + from_ground[:, None] * ground


def ground_light(
    irradiance: Float[Tensor, "3"], ground_reflectance: float, degree: int
) -> Float[Tensor, "coeff 3"]:
    """SH light of level, matt ground.

    Args:
        irradiance: What arrives at level ground.
        ground_reflectance: 0 to 1.
        degree: SH degree of the light.
    """
    from_ground = _half_spheres(degree)[1].to(irradiance)
    return from_ground[:, None] * (ground_reflectance / pi * irradiance)


def basis_of_one(direction: Float[Tensor, "3"], degree: int) -> Float[Tensor, "coeff"]:
    """`sh.basis` of one unit vector in a few operations, where that takes over a hundred.

    The basis is a polynomial of the degree in the vector: linear in the products of so many of
    (1, x, y, z). Training differentiates this in every iteration.
    """
    factor = torch.cat([direction.new_ones(1), direction])
    products = factor
    for _ in range(degree - 1):
        products = torch.outer(products, factor).reshape(-1)
    return _basis_from_products(degree).to(direction) @ products


@lru_cache(maxsize=4)
def _basis_from_products(degree: int) -> Float[Tensor, "coeff products"]:
    """Fitted to `sh.basis`, float64; exact, because more directions are taken than unknowns."""
    generator = torch.Generator().manual_seed(0)
    vectors = torch.randn(1000, 3, generator=generator, dtype=torch.float64)
    vectors = torch.nn.functional.normalize(vectors, dim=-1)
    factor = torch.cat([torch.ones(1000, 1, dtype=torch.float64), vectors], dim=1)
    products = factor
    for _ in range(degree - 1):
        products = torch.einsum("np,nf->npf", products, factor).flatten(1)
    fitted: Tensor = torch.linalg.pinv(products) @ sh.basis(vectors, degree)
    return fitted.T


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
    solid_angle = upper[..., 0] * sqrt(4 * pi)
    level = torch.einsum("hw,hws->s", solid_angle * -above[..., 1], radiance)
    return from_sky, lower.sum((0, 1)), level
