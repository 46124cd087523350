"""Reconstruction: L1 over unmasked pixels only (Sec. 3); SSIM is in `r3gw.training.losses.ssim`."""

import torch
from jaxtyping import Bool, Float
from torch import Tensor


def masked_l1(
    rendered: Float[Tensor, "h w 3"], target: Float[Tensor, "h w 3"], is_valid: Bool[Tensor, "h w"]
) -> Float[Tensor, ""]:
    """Mean absolute error over valid pixels and channels; 0 if there are none."""
    difference = torch.where(is_valid[..., None], (rendered - target).abs(), 0.0)
    return difference.sum() / (3 * is_valid.sum()).clamp_min(1)
