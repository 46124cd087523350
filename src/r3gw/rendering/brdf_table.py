"""The split-sum table F1, F2 over (n.v, roughness), integrated here.

``F1 * F0 + F2`` is the directional albedo of a GGX microfacet surface with Schlick's Fresnel
reflectivity F0 (Karis, "Real Shading in Unreal Engine 4", 2013): GGX normal distribution with
alpha = roughness**2 and the height-correlated Smith shadowing of Heitz (2014).
"""

from functools import lru_cache
from math import pi

import torch
from jaxtyping import Float
from torch import Tensor

SIZE = 256
NODES = 512  # Hammersley points per entry; the tests state the error.
SMALLEST_COSINE = 1e-4


@lru_cache(maxsize=1)
def brdf_table() -> Float[Tensor, "256 256 2"]:
    """F1 and F2 on a grid: row ``i`` is sqrt(n.v) = i/255, column ``j`` is roughness = j/255.

    The square root spends resolution on grazing views, where the integral changes fastest.
    """
    grid = torch.linspace(0.0, 1.0, SIZE, dtype=torch.float32)
    rows = [_integrate(float(cosine), grid) for cosine in grid.square()]
    return torch.stack(rows)


def _integrate(cosine: float, roughness: Float[Tensor, "r"]) -> Float[Tensor, "r 2"]:
    """F1 and F2 of one n.v for all roughnesses.

    Half vectors follow the distribution of visible normals (Heitz, "Sampling the GGX
    Distribution of Visible Normals", JCGT 7(4), 2018), which leaves the bounded weight
    G2(v, l) / G1(v).
    """
    cosine = max(cosine, SMALLEST_COSINE)
    sine = max(0.0, 1.0 - cosine * cosine) ** 0.5
    alpha = roughness[:, None].square()
    radius, azimuth = _hammersley()
    # The view in the space where the surface is a hemisphere; its y is 0.
    length = torch.sqrt((alpha * sine) ** 2 + cosine**2)
    view_x, view_z = alpha * sine / length, cosine / length
    across = radius * torch.cos(azimuth)
    rest = torch.sqrt(1 - across * across)
    tilt = 0.5 * (1 + view_z)
    along = (1 - tilt) * rest + tilt * radius * torch.sin(azimuth)
    out = torch.sqrt((1 - across * across - along * along).clamp_min(0))
    half_x = alpha * (out * view_x - along * view_z)
    half_y = alpha * across
    half_z = (out * view_z + along * view_x).clamp_min(1e-7)
    norm = torch.sqrt(half_x**2 + half_y**2 + half_z**2)
    v_h = ((half_x * sine + half_z * cosine) / norm).clamp(0, 1)
    n_l = 2 * v_h * half_z / norm - cosine
    lambda_v, lambda_l = _smith_lambda(cosine, alpha), _smith_lambda(n_l.clamp_min(1e-6), alpha)
    weight = torch.where(n_l > 0, (1 + lambda_v) / (1 + lambda_v + lambda_l), 0.0)
    fresnel = (1 - v_h) ** 5
    return torch.stack([(weight * (1 - fresnel)).mean(1), (weight * fresnel).mean(1)], dim=-1)


def _smith_lambda(
    cosine: float | Float[Tensor, "r s"], alpha: Float[Tensor, "r 1"]
) -> Float[Tensor, "r _"]:
    """Smith's Lambda of GGX: masking is G1 = 1 / (1 + Lambda)."""
    tangent2 = 1.0 / (cosine * cosine) - 1.0
    return 0.5 * (torch.sqrt(1 + alpha * alpha * tangent2) - 1)


@lru_cache(maxsize=1)
def _hammersley() -> tuple[Float[Tensor, "1 s"], Float[Tensor, "1 s"]]:
    """Radius and azimuth of low-discrepancy points that are uniform on the unit disk."""
    index = torch.arange(NODES)
    reversed_bits = torch.zeros(NODES)
    for bit in range(NODES.bit_length() - 1):
        reversed_bits += ((index >> bit) & 1) * 0.5 ** (bit + 1)
    radius = torch.sqrt((index + 0.5) / NODES)
    return radius[None], 2 * pi * (reversed_bits + 0.5 / NODES)[None]


def lookup(
    cosine: Float[Tensor, "n"], roughness: Float[Tensor, "n"]
) -> tuple[Float[Tensor, "n"], Float[Tensor, "n"]]:
    """Bilinear F1 and F2, differentiable in both arguments.

    Args:
        cosine: n.v in [0, 1].
        roughness: Disney roughness in [0, 1].
    """
    table = brdf_table().to(cosine)
    row = torch.sqrt(cosine.clamp(SMALLEST_COSINE, 1.0)) * (SIZE - 1)
    column = roughness.clamp(0.0, 1.0) * (SIZE - 1)
    above = row.detach().long().clamp(0, SIZE - 2)
    left = column.detach().long().clamp(0, SIZE - 2)
    down, right = (row - above)[:, None], (column - left)[:, None]
    upper = table[above, left] * (1 - right) + table[above, left + 1] * right
    lower = table[above + 1, left] * (1 - right) + table[above + 1, left + 1] * right
    f1, f2 = (upper * (1 - down) + lower * down).unbind(-1)
    return f1, f2
