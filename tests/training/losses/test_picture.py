"""The kernel of all picture losses against their plain forms in float64, with gradients."""

import pytest
import torch

from r3gw.geometry.cameras import Camera
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.rendering.channels import COLOUR, DEPTH, FOREGROUND, NORMAL, NUM_CHANNELS, SKY
from r3gw.training.losses import fused, plain
from r3gw.training.losses.forms import PictureWeights
from r3gw.training.losses.geometry import normal_loss, normals_from_depth
from r3gw.training.losses.reconstruction import masked_l1
from r3gw.training.losses.separation import separation_loss, silhouette_loss
from r3gw.training.losses.ssim import mean_ssim
from r3gw.training.losses.weighted import KnownLoss, sum_of

SMALLEST_ALPHA, SOLID = 1e-6, 0.3
WEIGHTS = PictureWeights(0.8, 0.2, 0.05, 0.5)
ALL_WEIGHTS = [
    WEIGHTS,
    PictureWeights(separation=0.5),
    PictureWeights(l1=0.8, dissimilarity=0.2),
    PictureWeights(dissimilarity=1.0),
    PictureWeights(normal=1.0),
    PictureWeights(silhouette=0.5),
    PictureWeights(0.8, 0.2, 0.05, silhouette=0.7),
]


def picture(height, width, seed=0):
    """Random planes over a sloping depth, a photo, masks with holes, a turned camera."""
    generator = torch.Generator().manual_seed(seed)
    planes = torch.rand(NUM_CHANNELS, height, width, generator=generator)
    alpha = 0.2 + 0.8 * torch.rand(height, width, generator=generator)
    slope = torch.linspace(0, 1, width) + 2 * torch.linspace(0, 1, height)[:, None]
    planes[DEPTH] = alpha * (4 + slope + 0.05 * planes[DEPTH])
    planes[NORMAL] -= 0.5
    target = (255 * torch.rand(3, height, width, generator=generator)).to(torch.uint8)
    is_valid = torch.rand(height, width, generator=generator) < 0.8
    is_valid[: height // 3, : width // 2] = False
    is_valid[-1, -1] = True
    is_sky = torch.rand(height, width, generator=generator) < 0.3
    pose = torch.eye(4, dtype=torch.float64)
    pose[:3, :3] = rotation_about_axis(1, 0.4) @ rotation_about_axis(0, 0.3)
    camera = Camera(pose, (0.9 * width, 0.8 * width, 0.4 * width, 0.6 * height), width, height)
    return planes, alpha, target, is_valid, is_sky, camera


def losses_by_hand(planes, alpha, target, is_valid, is_sky, camera):
    """Every loss from its definition, in the order of the weights."""
    colour, photo = planes[COLOUR].permute(1, 2, 0), target.permute(1, 2, 0).to(planes) / 255
    depth = planes[DEPTH] / alpha.clamp_min(SMALLEST_ALPHA)
    from_depth = normals_from_depth(depth, camera)
    return (
        masked_l1(colour, photo, is_valid),
        1 - mean_ssim(colour, photo, is_valid),
        normal_loss(planes[NORMAL].permute(1, 2, 0), from_depth, is_valid & ~is_sky),
        separation_loss(planes[FOREGROUND], planes[SKY], is_sky, is_valid),
        silhouette_loss(planes[FOREGROUND], is_sky, is_valid, SOLID),
    )


def gradients(loss, planes, alpha):
    return torch.autograd.grad(loss, (planes, alpha), materialize_grads=True)


@pytest.mark.parametrize("size", [(2, 2), (5, 7), (11, 16), (24, 33), (70, 40)])
@pytest.mark.parametrize("weights", ALL_WEIGHTS)
def test_values_and_gradients_equal_the_definitions(size, weights):
    planes, alpha, *rest = picture(*size)
    ours = planes.clone().requires_grad_(), alpha.clone().requires_grad_()
    theirs = planes.double().requires_grad_(), alpha.double().requires_grad_()
    found = fused.picture(*ours, *rest, weights, SOLID)
    assert isinstance(found.total, KnownLoss)
    expected = losses_by_hand(*theirs, *rest)
    for name, weight, exact in zip(weights._fields, weights, expected, strict=True):
        if weight > 0:
            value = getattr(found, name)
            assert value == pytest.approx(float(exact.detach()), rel=2e-5, abs=5e-5)
    total = sum(weight * exact for weight, exact in zip(weights, expected, strict=True))
    found_total = sum_of([found.total])
    torch.testing.assert_close(found_total.double(), total, rtol=2e-5, atol=5e-5)
    pairs = zip(gradients(3 * found_total, *ours), gradients(3 * total, *theirs), strict=True)
    for name, (gradient, exact) in zip(("planes", "alpha"), pairs, strict=True):
        largest = float(exact.abs().max())
        torch.testing.assert_close(
            *(gradient.double(), exact),
            rtol=1e-3,
            atol=3e-5 * largest,
            msg=lambda text, name=name: f"{name}: {text}",
        )


@pytest.mark.parametrize("weights", ALL_WEIGHTS)
def test_the_plain_form_puts_the_definitions_together(weights):
    """Of float64 tensors, which no kernel takes: `fused` hands them on to `plain`."""
    planes, alpha, *rest = picture(24, 33)
    leaves = planes.double().requires_grad_(), alpha.double().requires_grad_()
    expected = losses_by_hand(*leaves, *rest)
    total = sum(weight * exact for weight, exact in zip(weights, expected, strict=True))
    for form in (plain, fused):
        found = form.picture(*leaves, *rest, weights, SOLID)
        torch.testing.assert_close(sum_of([found.total]), total, rtol=1e-12, atol=1e-14)
        for name, weight, exact in zip(weights._fields, weights, expected, strict=True):
            value = float(exact.detach()) if weight > 0 else 0.0
            assert getattr(found, name) == pytest.approx(value, rel=1e-12, abs=1e-14)


def test_one_channel_serves_one_loss():
    both = PictureWeights(separation=0.5, silhouette=0.5)
    with pytest.raises(RuntimeError, match="the silhouette read one channel"):
        fused.picture(*picture(5, 7), both, SOLID)


def test_masked_pixels_have_no_say():
    planes, alpha, target, is_valid, is_sky, camera = picture(24, 33)
    no_normals = PictureWeights(0.8, 0.2, 0.0, 0.5)
    before = fused.picture(planes, alpha, target, is_valid, is_sky, camera, no_normals, SOLID)
    planes[COLOUR, ~is_valid], target[:, ~is_valid] = torch.nan, 77
    planes[FOREGROUND, ~is_valid], planes[SKY, ~is_valid] = 9.0, 9.0
    after = fused.picture(planes, alpha, target, is_valid, is_sky, camera, no_normals, SOLID)
    assert before.total.value == after.total.value


def test_nothing_valid():
    planes, alpha, target, is_valid, is_sky, camera = picture(24, 33)
    nowhere = torch.zeros_like(is_valid)
    planes.requires_grad_()
    found = fused.picture(planes, alpha, target, nowhere, is_sky, camera, WEIGHTS, SOLID)
    sum_of([found.total]).backward()
    assert found.total.value == 0.0
    assert not planes.grad.any()


def test_one_pixel_has_no_normal():
    """Means are the values and variances 0, up to what float32 leaves of their difference."""
    planes, alpha, target, _, is_sky, camera = picture(1, 1)
    everywhere = torch.ones(1, 1, dtype=torch.bool)
    found = fused.picture(planes, alpha, target, everywhere, is_sky, camera, WEIGHTS, SOLID)
    a, b = planes[COLOUR].flatten(), target.flatten() / 255
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
        found = fused.picture(*leaves, *rest, WEIGHTS, SOLID)
        sum_of([found.total]).backward()
        outcomes.append((found.total.value, *(leaf.grad.numpy().tobytes() for leaf in leaves)))
    torch.set_num_threads(1)
    assert outcomes[0] == outcomes[1] == outcomes[2]
