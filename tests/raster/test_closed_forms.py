"""What a rasterizer must draw where the answer can be written down, for both of ours."""

import math

import pytest
import torch

from r3gw.raster import rasterize, reference

RASTERIZERS = pytest.mark.parametrize(
    "rasterizer", [rasterize, reference.rasterize], ids=["kernels", "reference"]
)


def on_axis(rasterizer, depths, opacities, features, scale=0.2, size=33, focal=40.0, **options):
    """Isotropic Gaussians on the optical axis of a camera whose centre pixel sees them."""
    count = len(depths)
    means = torch.tensor([[0.0, 0.0, depth] for depth in depths])
    return rasterizer(
        means.requires_grad_(),
        torch.tensor([[1.0, 0.0, 0.0, 0.0]]).repeat(count, 1),
        torch.full((count, 3), scale),
        opacities if isinstance(opacities, torch.Tensor) else torch.tensor(opacities),
        torch.tensor(features),
        torch.eye(4),
        (focal, focal, size / 2, size / 2),
        size,
        size,
        **options,
    )


@RASTERIZERS
def test_one_gaussian_on_the_axis(rasterizer):
    background = torch.tensor([0.2, 0.1])
    result = on_axis(rasterizer, [2.0], [0.8], [[1.0, 3.0]], background=background)
    variance = (40.0 * 0.2 / 2.0) ** 2 + 0.3
    pixel = torch.arange(33) - 16.0
    squared = pixel[:, None] ** 2 + pixel**2
    alpha = 0.8 * torch.exp(-squared / (2 * variance))
    alpha = torch.where(alpha >= 1 / 255, alpha, 0)
    colour = alpha[..., None] * torch.tensor([1.0, 3.0]) + (1 - alpha[..., None]) * background
    torch.testing.assert_close(result.alpha, alpha, rtol=1e-5, atol=1e-6)
    torch.testing.assert_close(result.features, colour, rtol=1e-5, atol=1e-6)
    radius = math.sqrt(2 * math.log(255 * 0.8) * variance)
    torch.testing.assert_close(result.radii_px, torch.tensor([radius]), rtol=1e-5, atol=0)
    torch.testing.assert_close(result.means2d, torch.tensor([[16.5, 16.5]]), rtol=0, atol=1e-5)


@RASTERIZERS
@pytest.mark.parametrize("depths", [[2.0, 3.0], [3.0, 2.0], [2.0, 2.0]])
def test_two_overlapping_gaussians(rasterizer, depths):
    """Front to back by depth; equal depths in the order of their indices."""
    opacities = torch.tensor([0.6, 0.7], requires_grad=True)
    result = on_axis(rasterizer, depths, opacities, [[1.0], [5.0]])
    front, back = (1, 0) if depths[0] > depths[1] else (0, 1)
    o, f = [0.6, 0.7], [1.0, 5.0]
    expected = o[front] * f[front] + (1 - o[front]) * o[back] * f[back]
    assert float(result.features[16, 16, 0].detach()) == pytest.approx(expected, rel=1e-5)
    assert float(result.alpha[16, 16].detach()) == pytest.approx(1 - 0.4 * 0.3, rel=1e-5)
    result.features[16, 16, 0].backward()
    gradient = [0.0, 0.0]
    gradient[front] = f[front] - o[back] * f[back]
    gradient[back] = (1 - o[front]) * f[back]
    torch.testing.assert_close(opacities.grad, torch.tensor(gradient), rtol=1e-4, atol=1e-6)


@RASTERIZERS
def test_opaque_gaussian_is_clamped_and_loses_its_gradient(rasterizer):
    opacities = torch.tensor([1.0], requires_grad=True)
    result = on_axis(rasterizer, [2.0], opacities, [[1.0]])
    assert float(result.alpha[16, 16].detach()) == pytest.approx(0.99, rel=1e-6)
    result.alpha[16, 16].backward()
    assert opacities.grad.item() == 0.0


@RASTERIZERS
def test_pixel_takes_nothing_once_its_transmittance_has_run_out(rasterizer):
    # 0.05^3 = 1.25e-4 still takes the fourth; 0.05^4 = 6.25e-6 takes no fifth.
    values = [[0.0], [0.0], [0.0], [1e4], [1e9]]
    result = on_axis(rasterizer, [1.0, 2.0, 3.0, 4.0, 5.0], [0.95] * 5, values)
    assert result.features[16, 16, 0].item() == pytest.approx(1e4 * 0.95 * 0.05**3, rel=1e-4)
    assert result.alpha[16, 16].item() == pytest.approx(1 - 0.05**4, abs=1e-7)


@RASTERIZERS
def test_near_plane(rasterizer):
    result = on_axis(rasterizer, [0.0099, 0.0101], [0.5, 0.5], [[1.0], [1.0]], scale=1e-3)
    assert (result.radii_px > 0).tolist() == [False, True]


def test_footprint_matches_exactly_projected_samples():
    """A small tilted Gaussian off the axis against the moments of a cloud of its points."""
    generator = torch.Generator().manual_seed(0)
    mean = torch.tensor([[0.7, -0.4, 2.0]])
    quaternion, scales = torch.tensor([[0.8, 0.3, -0.4, 0.2]]), torch.tensor([[0.08, 0.03, 0.05]])
    focal, size = 100.0, 128
    result = rasterize(
        *(mean, quaternion, scales, torch.tensor([0.9]), torch.ones(1, 1)),
        *(torch.eye(4), (focal, focal, size / 2, size / 2), size, size),
    )
    rotation = reference._rotations(quaternion)[0]
    points = mean + (torch.randn(400_000, 3, generator=generator) * scales) @ rotation.T
    projected = focal * points[:, :2] / points[:, 2:] + size / 2

    weight = result.alpha / result.alpha.sum()
    centres = torch.arange(size) + 0.5
    grid = torch.stack(torch.meshgrid(centres, centres, indexing="xy"), dim=-1)
    drawn_mean = (weight[..., None] * grid).sum((0, 1))
    offset = grid - drawn_mean
    covariance = torch.einsum("hw,hwi,hwj->ij", weight, offset, offset)
    torch.testing.assert_close(drawn_mean, projected.mean(0), rtol=0, atol=0.15)
    expected = torch.cov(projected.T) + 0.3 * torch.eye(2)
    torch.testing.assert_close(covariance, expected, rtol=0.05, atol=0.1)


@RASTERIZERS
def test_opposite_pulls_cancel_in_the_gradient_alone(rasterizer):
    """All pixels want a Gaussian in the middle to come nearer: it stays, but is pulled."""
    pulls2d = torch.zeros(1, 2, requires_grad=True)
    result = on_axis(rasterizer, [2.0], [0.8], [[1.0]], pulls2d=pulls2d)
    pixel = torch.arange(33) - 16.0
    weight = pixel.abs().sign().expand(33, 33)
    (result.features[..., 0] * weight).sum().backward()
    variance = (40.0 * 0.2 / 2.0) ** 2 + 0.3
    squared = pixel[:, None] ** 2 + pixel**2
    alpha = 0.8 * torch.exp(-squared / (2 * variance))
    alpha = torch.where(alpha >= 1 / 255, alpha, 0) * weight
    expected = torch.stack([alpha * pixel.abs(), alpha * pixel[:, None].abs()]).sum((1, 2))
    torch.testing.assert_close(result.means2d.grad, torch.zeros(1, 2), rtol=0, atol=1e-4)
    torch.testing.assert_close(pulls2d.grad, expected[None] / variance, rtol=1e-5, atol=0)
