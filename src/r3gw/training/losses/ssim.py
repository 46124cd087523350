"""Masked SSIM in plain torch.

Wang et al., "Image Quality Assessment", 2004: Gaussian window of 11 px, sigma 1.5, data range 1.
Masked pixels of both pictures are left out by renormalising the window over valid pixels
(normalised convolution), so nothing leaks from them; the frame's outside counts as masked.
"""

import torch
from jaxtyping import Bool, Float
from torch import Tensor

WINDOW_PX = 11
SIGMA_PX = 1.5
C1, C2 = 0.01**2, 0.03**2


def mean_ssim(
    rendered: Float[Tensor, "h w 3"], target: Float[Tensor, "h w 3"], is_valid: Bool[Tensor, "h w"]
) -> Float[Tensor, ""]:
    """Mean SSIM over valid pixels and channels; 1 if there are none."""
    weight = is_valid.to(rendered.dtype)
    total = _blur(weight[None, None]).clamp_min(1e-8)

    def local_mean(image: Tensor) -> Tensor:
        return _blur((image * weight[..., None]).permute(2, 0, 1)[:, None]) / total

    mean_a, mean_b = local_mean(rendered), local_mean(target)
    var_a = local_mean(rendered * rendered) - mean_a * mean_a
    var_b = local_mean(target * target) - mean_b * mean_b
    covariance = local_mean(rendered * target) - mean_a * mean_b
    luminance = (2 * mean_a * mean_b + C1) / (mean_a**2 + mean_b**2 + C1)
    structure = (2 * covariance + C2) / (var_a + var_b + C2)
    similarity = luminance * structure * weight
    return torch.where(weight.sum() > 0, similarity.sum() / (3 * weight.sum()).clamp_min(1), 1.0)


def _blur(images: Float[Tensor, "c 1 h w"]) -> Float[Tensor, "c 1 h w"]:
    offsets = torch.arange(WINDOW_PX, dtype=images.dtype, device=images.device) - WINDOW_PX // 2
    kernel = torch.exp(-0.5 * (offsets / SIGMA_PX) ** 2)
    kernel = kernel / kernel.sum()
    half = WINDOW_PX // 2
    rows = torch.nn.functional.conv2d(images, kernel.view(1, 1, 1, -1), padding=(0, half))
    return torch.nn.functional.conv2d(rows, kernel.view(1, 1, -1, 1), padding=(half, 0))
