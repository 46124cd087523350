"""The kernel of all picture losses against their plain forms in float64, with gradients."""

import pytest
import torch

from r3gw.geometry.cameras import Camera
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.training.losses.geometry import normal_loss, normals_from_depth
from r3gw.training.losses.known_gradient import sum_of
from r3gw.training.losses.picture import PictureWeights, picture_losses
from r3gw.training.losses.reconstruction import masked_l1
from r3gw.training.losses.separation import separation_loss
from r3gw.training.losses.ssim import mean_ssim

SMALLEST_ALPHA = 1e-6
WEIGHTS = PictureWeights(0.8, 0.2, 0.05, 0.5)


def picture(height, width, seed=0):
    """Random planes over a sloping depth, a photo, masks with holes, a turned camera."""
    generator = torch.Generator().manual_seed(seed)
    planes = torch.rand(9, height, width, generator=generator)
    alpha = 0.2 + 0.8 * torch.rand(height, width, generator=generator)
    slope = torch.linspace(0, 1, width) + 2 * torch.linspace(0, 1, height)[:, None]
    planes[3] = alpha * (4 + slope + 0.05 * planes[3])
    planes[4:7] -= 0.5
    target = (255 * torch.rand(3, height, width, generator=generator)).to(torch.uint8)
    is_valid = torch.rand(height, width, generator=generator) < 0.8
    is_valid[: height // 3, : width // 2] = False
    is_valid[-1, -1] = True
    is_sky = torch.rand(height, width, generator=generator) < 0.3
    pose = torch.eye(4, dtype=torch.float64)
    pose[:3, :3] = rotation_about_axis(1, 0.4) @ rotation_about_axis(0, 0.3)
    camera = Camera(pose, (0.9 * width, 0.8 * width, 0.4 * width, 0.6 * height), width, height)
    return planes, alpha, target, is_valid, is_sky, camera


def plain_losses(planes, alpha, target, is_valid, is_sky, camera):
    """L1, 1 - SSIM, normal and separation loss from the plain forms."""
    colour, photo = planes[:3].permute(1, 2, 0), target.permute(1, 2, 0).to(planes) / 255
    depth = planes[3] / alpha.clamp_min(SMALLEST_ALPHA)
    from_depth = normals_from_depth(depth, camera)
    return (
        masked_l1(colour, photo, is_valid),
        1 - mean_ssim(colour, photo, is_valid),
        normal_loss(planes[4:7].permute(1, 2, 0), from_depth, is_valid & ~is_sky),
        separation_loss(planes[7], planes[8], is_sky, is_valid),
    )


def gradients(loss, planes, alpha):
    return torch.autograd.grad(loss, (planes, alpha), materialize_grads=True)


@pytest.mark.parametrize("size", [(2, 2), (5, 7), (11, 16), (24, 33), (70, 40)])
@pytest.mark.parametrize(
    "weights",
    [
        WEIGHTS,
        PictureWeights(0.0, 0.0, 0.0, 0.5),
        PictureWeights(0.8, 0.2, 0.0, 0.0),
        PictureWeights(0.0, 1.0, 0.0, 0.0),
        PictureWeights(0.0, 0.0, 1.0, 0.0),
    ],
)
def test_values_and_gradients_equal_the_plain_forms(size, weights):
    planes, alpha, *rest = picture(*size)
    ours = planes.clone().requires_grad_(), alpha.clone().requires_grad_()
    theirs = planes.double().requires_grad_(), alpha.double().requires_grad_()
    found = picture_losses(*ours, *rest, weights)
    expected = plain_losses(*theirs, *rest)
    named = (
        (weights.l1, found.l1),
        (weights.dissimilarity, found.dissimilarity),
        (weights.normal, found.normal),
        (weights.separation, found.separation),
    )
    for (weight, value), plain in zip(named, expected, strict=True):
        if weight > 0:
            assert value == pytest.approx(float(plain.detach()), rel=2e-5, abs=5e-5)
    total = sum(weight * plain for (weight, _), plain in zip(named, expected, strict=True))
    found_total = sum_of([found.total])
    torch.testing.assert_close(found_total.double(), total, rtol=2e-5, atol=5e-5)
    pairs = zip(gradients(3 * found_total, *ours), gradients(3 * total, *theirs), strict=True)
    for name, (gradient, plain) in zip(("planes", "alpha"), pairs, strict=True):
        largest = float(plain.abs().max())
        torch.testing.assert_close(
            *(gradient.double(), plain),
            rtol=1e-3,
            atol=3e-5 * largest,
            msg=lambda text, name=name: f"{name}: {text}",
        )


def test_masked_pixels_have_no_say():
    planes, alpha, target, is_valid, is_sky, camera = picture(24, 33)
    no_normals = PictureWeights(0.8, 0.2, 0.0, 0.5)
    before = picture_losses(planes, alpha, target, is_valid, is_sky, camera, no_normals)
    planes[:3, ~is_valid], planes[7:, ~is_valid], target[:, ~is_valid] = torch.nan, 9.0, 77
    after = picture_losses(planes, alpha, target, is_valid, is_sky, camera, no_normals)
    assert before.total.value == after.total.value


def test_nothing_valid():
    planes, alpha, target, is_valid, is_sky, camera = picture(24, 33)
    nowhere = torch.zeros_like(is_valid)
    planes.requires_grad_()
    found = picture_losses(planes, alpha, target, nowhere, is_sky, camera, WEIGHTS)
    sum_of([found.total]).backward()
    assert found.total.value == 0.0
    assert not planes.grad.any()


def test_one_pixel_has_no_normal():
    """Means are the values and variances 0, up to what float32 leaves of their difference."""
    planes, alpha, target, _, is_sky, camera = picture(1, 1)
    everywhere = torch.ones(1, 1, dtype=torch.bool)
    found = picture_losses(planes, alpha, target, everywhere, is_sky, camera, WEIGHTS)
    a, b = planes[:3].flatten(), target.flatten() / 255
    luminance = (2 * a * b + 1e-4) / (a * a + b * b + 1e-4)
    assert found.dissimilarity == pytest.approx(1 - float(luminance.mean()), abs=2e-4)
    assert found.l1 == pytest.approx(float((a - b).abs().mean()), abs=1e-6)
    assert found.normal == 0.0


def test_bytes_do_not_depend_on_threads():
    planes, alpha, *rest = picture(100, 61)
    outcomes = []
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        leaves = planes.clone().requires_grad_(), alpha.clone().requires_grad_()
        found = picture_losses(*leaves, *rest, WEIGHTS)
        sum_of([found.total]).backward()
        outcomes.append((found.total.value, *(leaf.grad.numpy().tobytes() for leaf in leaves)))
    torch.set_num_threads(1)
    assert outcomes[0] == outcomes[1] == outcomes[2]
