"""Shading against closed forms and gradients by finite differences."""

from math import pi, sqrt

import torch

from r3gw.lighting import sh
from r3gw.rendering.brdf_table import lookup
from r3gw.rendering.cook_torrance import diffuse, face_camera, shade, specular


def unit(*vectors: tuple[float, float, float]) -> torch.Tensor:
    return torch.nn.functional.normalize(torch.tensor(vectors, dtype=torch.float32), dim=-1)


def constant_light(radiance: float) -> torch.Tensor:
    light = torch.zeros(25, 3)
    light[0] = radiance * sqrt(4 * pi)
    return light


def patch_light(direction: torch.Tensor) -> torch.Tensor:
    """Band-limited light of one tiny bright patch: the basis at its direction."""
    return sh.basis(direction, 4)[0][:, None].repeat(1, 3)


def test_white_wall_under_constant_light_shows_the_light():
    normals = unit((0, 0, 1), (1, 1, 0))
    found = diffuse(normals, torch.ones(2, 3), constant_light(0.7))
    torch.testing.assert_close(found, torch.full((2, 3), 0.7), rtol=1e-5, atol=0)


def test_constant_light_reflects_by_the_table():
    normals, to_camera = unit((0, 0, 1)), unit((0.6, 0, 0.8))
    roughness = torch.tensor([0.4])
    f1, f2 = lookup(torch.tensor([0.8]), roughness)
    expected = (0.5 * (0.04 * f1 + f2))[:, None].expand(1, 3)
    found = specular(normals, to_camera, roughness, constant_light(0.5))
    torch.testing.assert_close(found, expected, rtol=1e-5, atol=0)


def test_diffuse_and_specular_agree_on_where_light_comes_from():
    """One patch in direction d: irradiance peaks at n = d, reflection at r = d."""
    generator = torch.Generator().manual_seed(0)
    candidates = torch.nn.functional.normalize(torch.randn(4000, 3, generator=generator), dim=-1)
    for d in unit((0.3, -0.8, 0.5), (-0.9, 0.1, -0.2), (0.2, 0.4, -0.9)):
        light = patch_light(d[None])
        by_normal = diffuse(candidates, torch.ones(4000, 3), light)[:, 0]
        to_camera = candidates  # seen head on, the reflection leaves along the normal
        by_reflection = specular(candidates, to_camera, torch.full((4000,), 0.1), light)[:, 0]
        assert float(candidates[by_normal.argmax()] @ d) > 0.99
        assert float(candidates[by_reflection.argmax()] @ d) > 0.99


def test_mirror_direction():
    """Light from the mirrored side lights the surface; from the camera's side it does not."""
    normal, to_camera = unit((0, 0, 1)), unit((0.7, 0, 0.7))
    rough = torch.tensor([0.05])
    mirrored = specular(normal, to_camera, rough, patch_light(unit((-0.7, 0, 0.7))))
    same_side = specular(normal, to_camera, rough, patch_light(unit((0.7, 0, 0.7))))
    assert float(mirrored[0, 0]) > 10 * float(same_side[0, 0])


def test_faces_the_camera():
    normals = unit((0, 0, 1), (0, 0, -1))
    to_camera = unit((0.1, 0, 1), (0.1, 0, 1))
    assert ((face_camera(normals, to_camera) * to_camera).sum(-1) > 0).all()


def test_gradients_by_finite_differences():
    generator = torch.Generator().manual_seed(3)

    def draw(*shape: int) -> torch.Tensor:
        return torch.randn(*shape, generator=generator, dtype=torch.float64)

    to_camera = torch.nn.functional.normalize(draw(4, 3), dim=-1)
    normals = face_camera(torch.nn.functional.normalize(draw(4, 3), dim=-1), to_camera)
    albedo, roughness = torch.rand(4, 3).double(), torch.tensor([0.31, 0.44, 0.61, 0.81]).double()
    light = 0.1 * draw(25, 3)
    light[0] += 4.0
    inputs = [x.requires_grad_() for x in (normals, albedo, roughness, light)]

    def colour(n, a, r, c):
        return shade(n, to_camera, a, r, c, with_specular=True)

    assert torch.autograd.gradcheck(colour, inputs, eps=1e-7, atol=1e-5)
