"""Exact rotation of spherical-harmonics coefficients.

Each band spans a rotation-invariant space, so its rotation matrix is fixed by how the basis
transforms at enough directions: ``Y(R^-1 d) = M^T Y(d)`` holds for every d, and solving it for
more directions than the band has functions recovers M to rounding error.
"""

from functools import lru_cache

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.lighting import sh


def rotate(
    coefficients: Float[Tensor, "coeff c"], rotation: Float[Tensor, "3 3"]
) -> Float[Tensor, "coeff c"]:
    """Turn a light: the result shines from ``rotation @ d`` what the input shone from ``d``.

    Args:
        coefficients: Light of any supported degree, or any functions of direction, one a column.
        rotation: Right-handed rotation matrix.
    """
    degree = int(coefficients.shape[0] ** 0.5) - 1
    directions, after = _probes(degree)
    before = sh.basis(directions @ rotation.double(), degree)  # rows: R^T d
    # radiance after(d) = before(R^T d): solve after @ new = before @ old in least squares.
    turned: Tensor = torch.linalg.lstsq(after, before @ coefficients.double()).solution
    return turned.to(coefficients.dtype).contiguous()


@lru_cache(maxsize=4)
def _probes(degree: int) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n coeff"]]:
    """Directions enough to settle all coefficients, and the basis there."""
    count = 4 * sh.num_coefficients(degree)
    generator = torch.Generator().manual_seed(0)
    directions = torch.randn(count, 3, generator=generator, dtype=torch.float64)
    directions = torch.nn.functional.normalize(directions, dim=-1)
    return directions, sh.basis(directions, degree)
