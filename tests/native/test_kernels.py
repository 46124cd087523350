"""Operators have schemas and a CPU implementation; without one for a device, plain forms act."""

import pytest
import torch

from r3gw.native import kernels, ops

DEVICE_OPERATORS = (
    *("rasterize", "is_usable", "splats", "shade", "appearance", "picture_losses", "positivity"),
    *("flatness", "sky_depth", "adam_step", "add_gradient_norms"),
)
DIFFERENTIABLE = ("rasterize", "splats", "appearance")


@pytest.mark.parametrize("name", DEVICE_OPERATORS)
def test_operators_have_a_schema_and_a_kernel_for_the_cpu_alone(name):
    schema = str(getattr(torch.ops.r3gw, name).default._schema)
    assert "Tensor _0" not in schema, f"arguments of {schema} have no names"
    assert kernels.take(name, torch.zeros(3))
    assert not kernels.take(name, torch.zeros(3, device="meta"))
    assert not kernels.take(name, torch.zeros(3), torch.zeros(3, dtype=torch.float64))
    with kernels.switched_off():
        assert not kernels.take(name, torch.zeros(3))
    assert kernels.take(name, torch.zeros(3))


@pytest.mark.parametrize("name", DIFFERENTIABLE)
def test_differentiable_operators_do_so_per_device(name):
    has = torch._C._dispatch_has_kernel_for_dispatch_key
    assert has(f"r3gw::{name}", "AutogradCPU")
    assert not has(f"r3gw::{name}", "AutogradCUDA")


def test_a_device_without_a_kernel_is_named():
    scales, radii = torch.zeros(3, device="meta"), torch.zeros(3, device="meta")
    with pytest.raises(NotImplementedError, match=r"r3gw::flatness.*Meta"):
        ops.flatness(scales, radii, 1.0)


def test_inference_mode_needs_no_gradient():
    """There torch leaves the autograd implementations out."""
    weights = [torch.eye(3) for _ in range(6)]
    biases = [torch.zeros(3) for _ in range(6)]
    embedding = torch.tensor([[1.0, -2.0, 3.0]])
    with torch.inference_mode():
        light, sky = ops.appearance(embedding.clone(), 0, None, weights, biases)
    expected = torch.tensor([[1.0, 0.0, 3.0]])
    torch.testing.assert_close(light, expected, rtol=0, atol=0)
    torch.testing.assert_close(sky, expected, rtol=0, atol=0)
