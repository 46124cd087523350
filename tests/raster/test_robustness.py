"""Extreme but legal inputs are drawn without garbage; illegal ones are named."""

import pytest
import torch

from r3gw.raster import rasterize, validation

IDENTITY = torch.eye(4)


def parameters(count=5, channels=3, seed=0):
    """Legal inputs in front of an identity camera, as a dict in argument order."""
    generator = torch.Generator().manual_seed(seed)
    rand = lambda *shape: torch.rand(*shape, generator=generator)  # noqa: E731
    return {
        "means": rand(count, 3) + torch.tensor([-0.5, -0.5, 1.0]),
        "quaternions": rand(count, 4) + 0.1,
        "scales": 0.05 + 0.1 * rand(count, 3),
        "opacities": rand(count),
        "features": rand(count, channels),
    }


def draw(inputs, width=37, height=21, **options):
    """Rasterize and send a gradient of ones back; every output must be finite."""
    leaves = [value.clone().requires_grad_() for value in inputs.values()]
    intrinsics = (30.0, 30.0, width / 2, height / 2)
    result = rasterize(*leaves, IDENTITY, intrinsics, width, height, **options)
    (result.features.sum() + result.alpha.sum()).backward()
    for tensor in (result.features, result.alpha, result.radii_px, result.means2d):
        assert torch.isfinite(tensor).all()
    for leaf in leaves:
        assert torch.isfinite(leaf.grad).all()
    assert 0 <= result.alpha.min() <= result.alpha.max() <= 1
    return result


def test_no_gaussians():
    result = draw(parameters(count=0), background=torch.tensor([1.0, 2.0, 3.0]))
    assert torch.equal(result.features[5, 7], torch.tensor([1.0, 2.0, 3.0]))
    assert not result.alpha.any()


def test_all_behind_the_camera():
    inputs = parameters()
    inputs["means"][:, 2] *= -1
    result = draw(inputs)
    assert not result.radii_px.any()
    assert not result.alpha.any()


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (40, 1), (15, 17), (16, 32)])
def test_image_sizes(size):
    draw(parameters(), *size)


@pytest.mark.parametrize("scale", [0.0, 1e-30, 1e3, 1e6, 1e12, 3e38])
def test_degenerate_and_huge_scales(scale):
    inputs = parameters()
    inputs["scales"][:] = scale
    result = draw(inputs)
    if scale <= 1e6:
        assert (result.radii_px > 0).all()


def test_needles_and_sheets():
    inputs = parameters(count=30)
    inputs["scales"][:10, :2] = 0.0
    inputs["scales"][10:20, 0] = 1e5
    inputs["scales"][20:, 2] = 0.0
    draw(inputs)


def test_far_outside_the_frustum_near_the_camera_plane():
    inputs = parameters()
    inputs["means"][:, 2] = 0.011
    inputs["means"][:, 0] = 50.0
    inputs["scales"][:] = 5.0
    draw(inputs)


def test_extreme_quaternion_lengths():
    inputs = parameters()
    expected = draw(inputs).features
    for factor in (1e-15, 1e15):
        scaled = inputs | {"quaternions": inputs["quaternions"] * factor}
        torch.testing.assert_close(draw(scaled).features, expected, rtol=1e-5, atol=1e-6)


def test_300k_gaussians_on_one_pixel():
    inputs = parameters(count=300_000)
    inputs["means"][:] = torch.tensor([0.0, 0.0, 1.0])
    inputs["scales"][:] = 1e-4
    inputs["opacities"][:] = 0.005
    assert draw(inputs, 1, 1).alpha.item() == pytest.approx(1.0, abs=1e-4)


def test_strided_inputs_and_3x4_camera():
    inputs = parameters()
    expected = draw(inputs).features
    strided = [torch.stack([value, value], dim=-1)[..., 0] for value in inputs.values()]
    result = rasterize(*strided, IDENTITY[:3], (30.0, 30.0, 18.5, 10.5), 37, 21)
    assert torch.equal(result.features, expected)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
@pytest.mark.parametrize("name", ["means", "quaternions", "scales", "opacities", "features"])
def test_bad_values_are_named_and_counted(name, bad):
    inputs = parameters()
    inputs[name].view(-1)[1] = bad
    inputs[name].view(-1)[3] = bad
    with pytest.raises(ValueError, match=rf"{name} must be .*: 2 of {inputs[name].numel()} "):
        draw(inputs)


@pytest.mark.parametrize(
    ("name", "bad", "message"),
    [
        ("scales", -1e-3, "scales must be finite and not negative: 1 of"),
        ("opacities", 1.001, r"opacities must be in \[0, 1\]: 1 of"),
        ("opacities", -1e-6, r"opacities must be in \[0, 1\]: 1 of"),
        ("quaternions", 0.0, "quaternions must have a length above 0: 1 of 5"),
    ],
)
def test_values_out_of_range(name, bad, message):
    inputs = parameters()
    inputs[name][1] = inputs[name][1] if name == "scales" else bad
    if name == "scales":
        inputs[name][1, 2] = bad
    with pytest.raises(ValueError, match=message):
        draw(inputs)


@pytest.mark.parametrize(
    ("tensor", "message"),
    [
        (torch.zeros(4, 3), r"means must have shape \[5, 3\], got \[4, 3\]"),
        (torch.zeros(5, 3, dtype=torch.int64), "means must be floating, got int64"),
        (torch.zeros(5), r"means must have shape \[5, 3\], got \[5\]"),
    ],
)
def test_shapes_and_types(tensor, message):
    with pytest.raises(ValueError, match=message):
        validation.check_shapes({"means": (tensor, (5, 3))})


def test_no_channels():
    with pytest.raises(ValueError, match=r"features must have shape \[5, any\]"):
        validation.check_shapes({"features": (torch.zeros(5, 0), (5, None))})


@pytest.mark.parametrize(
    ("camera", "intrinsics", "size", "message"),
    [
        (torch.eye(3), (1.0, 1.0, 0.0, 0.0), (4, 4), "cam_from_world must have shape"),
        (torch.eye(4) / 0, (1.0, 1.0, 0.0, 0.0), (4, 4), "cam_from_world must be finite"),
        (IDENTITY, (0.0, 1.0, 0.0, 0.0), (4, 4), "focal lengths must be positive"),
        (IDENTITY, (1.0, 1.0, 0.0), (4, 4), "four finite numbers"),
        (IDENTITY, (1.0, 1.0, 0.0, 0.0), (0, 4), "width and height must be"),
        (torch.eye(4).requires_grad_(), (1.0, 1.0, 0.0, 0.0), (4, 4), "must not require"),
    ],
)
def test_cameras(camera, intrinsics, size, message):
    with pytest.raises(ValueError, match=message):
        validation.check_camera(camera, intrinsics, *size)


def test_number_of_feature_gradients():
    with pytest.raises(ValueError, match=r"num_feature_gradients must be in 0..3, got 4"):
        draw(parameters(), num_feature_gradients=4)
