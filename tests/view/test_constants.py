"""What the page's scripts compute with is what the Python renderer computes with."""

from math import cos, sin

import numpy as np
import pytest
import torch

from r3gw.geometry.rotations import rotation_about_axis
from r3gw.lighting import sh
from r3gw.lighting.sh_rotation import rotate
from r3gw.rendering.brdf_table import lookup
from r3gw.view.constants import sh_norms, split_sum_table, yaw_harmonics


@pytest.mark.parametrize("yaw", [0.0, 0.3, -2.0, 3.1])
def test_turns_as_a_fourier_series_are_rotations(yaw):
    cosines, sines = yaw_harmonics()
    made = sum(
        cos(k * yaw) * c + sin(k * yaw) * s
        for k, (c, s) in enumerate(zip(cosines, sines, strict=True))
    )
    light = torch.randn(25, 3, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    expected = rotate(light, rotation_about_axis(1, yaw))
    np.testing.assert_allclose(made @ light.numpy(), expected.numpy(), rtol=0, atol=1e-7)


def test_norms_are_those_of_the_basis():
    """At +z the associated Legendre functions of order 0 are 1; elsewhere by quadrature."""
    norms = sh_norms()
    top = sh.basis(torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64), 4)
    zonal = [l * l + l for l in range(5)]
    np.testing.assert_allclose(np.array(norms)[zonal], top.numpy()[zonal], rtol=1e-12, atol=0)
    x_axis = sh.basis(torch.tensor([1.0, 0.0, 0.0], dtype=torch.float64), 4).numpy()
    # P_m^m(0) without the phase is (2m - 1)!!.
    double = {1: 1, 2: 3, 3: 15, 4: 105}
    for m, factor in double.items():
        assert norms[m * m + 2 * m] * factor == pytest.approx(x_axis[m * m + 2 * m], rel=1e-12)


def test_the_smaller_table_interpolates_like_the_whole():
    table = torch.from_numpy(split_sum_table().astype(np.float64))
    size = len(table)
    generator = torch.Generator().manual_seed(1)
    cosine = torch.rand(2000, generator=generator, dtype=torch.float64)
    roughness = torch.rand(2000, generator=generator, dtype=torch.float64)
    row, column = cosine.sqrt() * (size - 1), roughness * (size - 1)
    above, left = row.long().clamp(0, size - 2), column.long().clamp(0, size - 2)
    down, right = (row - above)[:, None], (column - left)[:, None]
    upper = table[above, left] * (1 - right) + table[above, left + 1] * right
    lower = table[above + 1, left] * (1 - right) + table[above + 1, left + 1] * right
    found = upper * (1 - down) + lower * down
    expected = torch.stack(lookup(cosine, roughness), dim=-1)
    assert float((found - expected).abs().max()) < 0.004
