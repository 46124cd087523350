"""Reconstruction: 0.8 L1 + 0.2 (1 - SSIM), over unmasked pixels only (Sec. 3)."""

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.training.losses.ssim import mean_ssim


def masked_l1(
    rendered: Float[Tensor, "h w 3"], target: Float[Tensor, "h w 3"], is_valid: Bool[Tensor, "h w"]
) -> Float[Tensor, ""]:
    """Mean absolute error over valid pixels and channels; 0 if there are none."""
    difference = torch.where(is_valid[..., None], (rendered - target).abs(), 0.0)
    return difference.sum() / (3 * is_valid.sum()).clamp_min(1)


def reconstruction_loss(
    rendered: Float[Tensor, "h w 3"],
    target: Float[Tensor, "h w 3"],
    is_valid: Bool[Tensor, "h w"],
    ssim_weight: float,
) -> Float[Tensor, ""]:
    """``(1 - w) L1 + w (1 - SSIM)`` of display values."""
    l1 = masked_l1(rendered, target, is_valid)
    if ssim_weight == 0:
        return l1
    dissimilarity = 1 - mean_ssim(rendered, target, is_valid)
    return (1 - ssim_weight) * l1 + ssim_weight * dissimilarity
