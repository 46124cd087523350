"""The fused SSIM against scikit-image and against its plain form in float64, with gradients."""

import numpy as np
import pytest
import torch
from skimage.metrics import structural_similarity

from r3gw.losses import ssim_reference
from r3gw.losses.ssim import mean_ssim


def pictures(height, width, seed=0):
    """Two related pictures and a mask with holes."""
    generator = torch.Generator().manual_seed(seed)
    first = torch.rand(height, width, 3, generator=generator)
    noise = 0.2 * torch.randn(height, width, 3, generator=generator)
    is_valid = torch.rand(height, width, generator=generator) < 0.7
    is_valid[: height // 3, : width // 2] = False
    return first, (first + noise).clamp(0, 1), is_valid


@pytest.mark.parametrize("size", [(5, 7), (11, 11), (24, 33), (70, 40)])
def test_value_and_gradient_equal_the_plain_form(size):
    first, second, is_valid = pictures(*size)
    is_valid[-1, -1] = True
    ours, theirs = first.clone().requires_grad_(), first.double().requires_grad_()
    value = mean_ssim(ours, second, is_valid)
    expected = ssim_reference.mean_ssim(theirs, second.double(), is_valid)
    (3 * value).backward()
    (3 * expected).backward()
    torch.testing.assert_close(value.double(), expected, rtol=1e-5, atol=5e-5)
    size = float(theirs.grad.abs().max())
    torch.testing.assert_close(ours.grad.double(), theirs.grad, rtol=1e-3, atol=2e-5 * size)
    assert not ours.grad[~is_valid].any()


def test_one_pixel():
    """Means are the values and variances 0, up to what float32 leaves of their difference."""
    first, second = torch.tensor([[[0.2, 0.5, 0.9]]]), torch.tensor([[[0.3, 0.5, 0.6]]])
    luminance = (2 * first * second + 1e-4) / (first**2 + second**2 + 1e-4)
    value = mean_ssim(first, second, torch.ones(1, 1, dtype=torch.bool))
    torch.testing.assert_close(value, luminance.mean(), rtol=0, atol=2e-4)


def test_unmasked_interior_equals_scikit_image():
    first, second, _ = pictures(40, 50)
    _, full = structural_similarity(
        *(first.numpy(), second.numpy()),
        data_range=1.0,
        channel_axis=-1,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        full=True,
    )
    # One more valid row changes nothing in the windows five rows further up, so the difference of
    # the two sums is the similarity of whole rows; scikit-image agrees except near the frame.
    everywhere = torch.ones(40, 50, dtype=torch.bool)
    total = float(mean_ssim(first, second, everywhere)) * full.size
    border = _border_sum(first, second)
    np.testing.assert_allclose(total - border, full[5:-5, 5:-5].sum(), rtol=1e-5, atol=0)


def _border_sum(first: torch.Tensor, second: torch.Tensor) -> float:
    """Sum of float64 similarities within five pixels of the frame, by brute force."""
    offsets = torch.arange(-5, 6, dtype=torch.float64)
    window = torch.exp(-0.5 * (offsets[:, None] ** 2 + offsets**2) / 1.5**2)
    a, b = first.double(), second.double()
    height, width = a.shape[:2]
    total = 0.0
    for y in range(height):
        for x in range(width):
            if 5 <= y < height - 5 and 5 <= x < width - 5:
                continue
            rows, columns = slice(max(y - 5, 0), y + 6), slice(max(x - 5, 0), x + 6)
            w = window[5 - min(y, 5) : 5 + height - y, 5 - min(x, 5) : 5 + width - x]
            w = (w / w.sum())[..., None]
            p, q = a[rows, columns], b[rows, columns]
            mean_p, mean_q = (w * p).sum((0, 1)), (w * q).sum((0, 1))
            covariance = (w * p * q).sum((0, 1)) - mean_p * mean_q
            variances = (w * (p * p + q * q)).sum((0, 1)) - mean_p**2 - mean_q**2
            luminance = (2 * mean_p * mean_q + 1e-4) / (mean_p**2 + mean_q**2 + 1e-4)
            structure = (2 * covariance + 9e-4) / (variances + 9e-4)
            total += float((luminance * structure).sum())
    return total


def test_masked_pixels_have_no_say():
    first, second, is_valid = pictures(24, 33)
    expected = mean_ssim(first, second, is_valid)
    first[~is_valid], second[~is_valid] = 7.0, -3.0
    assert torch.equal(mean_ssim(first, second, is_valid), expected)


def test_nothing_valid():
    first, second, is_valid = pictures(8, 9)
    first.requires_grad_()
    value = mean_ssim(first, second, torch.zeros_like(is_valid))
    value.backward()
    assert value.item() == 1.0
    assert not first.grad.any()


def test_bytes_do_not_depend_on_threads():
    first, second, is_valid = pictures(100, 60)
    outcomes = []
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        leaf = first.clone().requires_grad_()
        value = mean_ssim(leaf, second, is_valid)
        value.backward()
        outcomes.append((value.item(), leaf.grad.numpy().tobytes()))
    torch.set_num_threads(1)
    assert outcomes[0] == outcomes[1] == outcomes[2]


def test_target_has_no_gradient():
    first, second, is_valid = pictures(8, 9)
    with pytest.raises(ValueError, match="no gradient by its target"):
        mean_ssim(first, second.requires_grad_(), is_valid)
