"""The fused shading kernel against the plain form in float64, forward and backward."""

import pytest
import torch
from torch.nn.functional import normalize

from r3gw.shading import cook_torrance, fused


def surfaces(count, coefficients, seed=0):
    """Normals that face the camera, and everything else `shade` takes; a light partly negative."""
    generator = torch.Generator().manual_seed(seed)
    to_camera = normalize(torch.randn(count, 3, generator=generator), dim=-1)
    normals = normalize(torch.randn(count, 3, generator=generator), dim=-1)
    normals = cook_torrance.face_camera(normals, to_camera)
    albedo, roughness = torch.rand(count, 4, generator=generator).split([3, 1], dim=-1)
    light = 0.4 * torch.randn(coefficients, 3, generator=generator)
    light[0] += 1.0
    return normals, to_camera, albedo, roughness[:, 0], light


def run(shade, inputs, dtype, with_specular):
    """Colours and the gradients of their weighted sum by normals, albedo, roughness and light."""
    leaves = [value.to(dtype, copy=True).requires_grad_() for value in inputs]
    leaves[1] = leaves[1].detach()
    colours = shade(*leaves, with_specular=with_specular)
    weights = torch.randn(colours.shape, generator=torch.Generator().manual_seed(1))
    (colours * weights).sum().backward()
    gradients = [leaf.grad for leaf in leaves if leaf.requires_grad]
    return [colours.detach(), *[torch.zeros(()) if g is None else g for g in gradients]]


@pytest.mark.parametrize("coefficients", [9, 25])
@pytest.mark.parametrize("with_specular", [True, False])
@pytest.mark.parametrize("count", [0, 1, 16, 500])
def test_equals_the_plain_form(count, coefficients, with_specular):
    inputs = surfaces(count, coefficients)
    ours = run(fused.shade, inputs, torch.float32, with_specular)
    theirs = run(cook_torrance.shade, inputs, torch.float64, with_specular)
    names = ("colours", "normals", "albedo", "roughness", "light")
    for name, actual, expected in zip(names, ours, theirs, strict=True):
        size = float(expected.abs().max()) if expected.numel() else 0.0
        torch.testing.assert_close(
            *(actual.double(), expected.double().expand_as(actual)),
            rtol=1e-3,
            atol=2e-5 * max(size, 1.0),
            msg=lambda text, name=name: f"{name}: {text}",
        )


def test_bytes_do_not_depend_on_threads():
    inputs = surfaces(10_000, 25)
    outcomes = []
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        outputs = run(fused.shade, inputs, torch.float32, with_specular=True)
        outcomes.append([output.numpy().tobytes() for output in outputs])
    torch.set_num_threads(1)
    assert outcomes[0] == outcomes[1] == outcomes[2]


def test_degrees_without_a_kernel_are_an_error():
    with pytest.raises(ValueError, match="needs 9 or 25 light coefficients, got 16"):
        fused.shade(*surfaces(3, 16), with_specular=True)


def test_view_directions_have_no_gradient():
    inputs = surfaces(3, 25)
    inputs[1].requires_grad_()
    with pytest.raises(ValueError, match="no gradient by to_camera"):
        fused.shade(*inputs, with_specular=True)
