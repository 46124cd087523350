"""The plain SSIM, which the kernel is held against, against scikit-image and brute force."""

import numpy as np
import torch
from skimage.metrics import structural_similarity

from r3gw.training.losses.ssim import mean_ssim


def pictures(height, width, seed=0):
    """Two related pictures."""
    generator = torch.Generator().manual_seed(seed)
    first = torch.rand(height, width, 3, generator=generator)
    noise = 0.2 * torch.randn(height, width, 3, generator=generator)
    return first, (first + noise).clamp(0, 1)


def test_unmasked_interior_equals_scikit_image():
    first, second = pictures(40, 50)
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
