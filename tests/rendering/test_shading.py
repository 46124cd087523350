"""The shading kernel of relit pictures against plain torch in float64, which it falls back to."""

from math import pi

import pytest
import torch

from r3gw.native import ops
from r3gw.rendering import cook_torrance, shading

COUNT = 333  # not a multiple of sixteen


def unit(generator):
    return torch.nn.functional.normalize(torch.randn(COUNT, 3, generator=generator), dim=-1)


@pytest.fixture
def surfaces():
    """Normals that face the camera, directions, albedo, roughness."""
    generator = torch.Generator().manual_seed(0)
    to_camera = unit(generator)
    normals = cook_torrance.face_camera(unit(generator), to_camera)
    albedo = torch.rand(COUNT, 3, generator=generator)
    return normals, to_camera, albedo, torch.rand(COUNT, generator=generator)


def random_light(coefficients):
    light = 0.4 * torch.randn(coefficients, 3, generator=torch.Generator().manual_seed(1))
    light[0] += 2.0
    return light


@pytest.mark.parametrize("with_specular", [False, True])
@pytest.mark.parametrize("coefficients", [9, 16, 25])  # 16 has no kernel
def test_equals_plain_torch(surfaces, coefficients, with_specular):
    light = random_light(coefficients)
    found = shading.shade(*surfaces, light, with_specular=with_specular)
    exact = [tensor.double() for tensor in (*surfaces, light)]
    expected = cook_torrance.shade(*exact, with_specular=with_specular)
    torch.testing.assert_close(found.double(), expected, rtol=1e-4, atol=1e-5)


def test_bytes_do_not_depend_on_threads(surfaces):
    many = [tensor.repeat(20, *[1] * (tensor.dim() - 1)) for tensor in surfaces]
    outcomes = set()
    for threads in (1, 3):
        torch.set_num_threads(threads)
        outcomes.add(shading.shade(*many, random_light(25), with_specular=True).numpy().tobytes())
    torch.set_num_threads(1)
    assert len(outcomes) == 1


def test_gradients_are_those_of_plain_torch(surfaces, monkeypatch):
    """The kernel has none, so a learned tensor must not reach it."""
    monkeypatch.setattr(ops, "shade", None)
    normals, to_camera, albedo, roughness = surfaces
    albedo.requires_grad_()
    light = random_light(9)
    shading.shade(
        normals, to_camera, albedo, roughness, light, with_specular=False
    ).sum().backward()
    expected = cook_torrance.diffuse(normals, torch.ones_like(albedo), light)
    torch.testing.assert_close(albedo.grad, expected, rtol=1e-5, atol=1e-6)


def test_foreground_is_turned_to_the_camera_and_shadowed(surfaces):
    """Under even light of radiance 1 irradiance is pi; a shadow takes its transfer from it."""
    normals, _, albedo, roughness = surfaces
    means = torch.randn(COUNT, 3, generator=torch.Generator().manual_seed(2))
    light = torch.zeros(25, 3)
    light[0] = (4 * pi) ** 0.5
    occlusion = torch.zeros(COUNT, 25)
    occlusion[:, 0] = -0.25 * pi / light[0, 0]
    centre = torch.tensor([0.0, 0.0, -9.0], dtype=torch.float64)
    arguments = (albedo, roughness, centre, light)
    open_sky = shading.shade_foreground(means, normals, *arguments, with_specular=False)
    torch.testing.assert_close(open_sky, albedo, rtol=1e-5, atol=1e-6)
    shadowed = shading.shade_foreground(
        means, normals, *arguments, with_specular=False, occlusion=occlusion
    )
    torch.testing.assert_close(shadowed, 0.75 * albedo, rtol=1e-5, atol=1e-6)
    pair = [
        shading.shade_foreground(means, side * normals, *arguments, with_specular=True)
        for side in (1.0, -1.0)
    ]
    torch.testing.assert_close(*pair, rtol=0, atol=0)
