"""Keeping sky and foreground apart: Eq. 15 or a silhouette in the picture, Eq. 16 in depth."""

import torch
from jaxtyping import Bool, Float
from torch import Tensor


def separation_loss(
    foreground: Float[Tensor, "h w"],
    sky: Float[Tensor, "h w"],
    is_sky: Bool[Tensor, "h w"],
    is_valid: Bool[Tensor, "h w"],
) -> Float[Tensor, ""]:
    """Mean, over valid pixels and channels, of each set's colour where the other belongs.

    Args:
        foreground, sky: Channel sums of the foreground-only and sky-only renders.
        is_sky: True on sky pixels.
        is_valid: False on occluders, which count in neither term.
    """
    wrong = torch.where(is_sky, foreground, sky)
    return torch.where(is_valid, wrong, 0.0).sum() / (3 * is_valid.sum()).clamp_min(1)


def silhouette_loss(
    opacity: Float[Tensor, "h w"],
    is_sky: Bool[Tensor, "h w"],
    is_valid: Bool[Tensor, "h w"],
    solid: float,
) -> Float[Tensor, ""]:
    """Mean, over valid pixels, of foreground on sky pixels and of what it lets through elsewhere.

    Unlike Eq. 15 it asks nothing of the sky, which may lie behind the foreground; Eq. 15 thins
    both sets along the outline, and the black behind them shows (docs/studies.md).

    Args:
        opacity: What the foreground contributes to the opacity.
        is_sky: True on sky pixels.
        is_valid: False on occluders.
        solid: Weight of what the foreground lets through where it belongs.
    """
    wrong = torch.where(is_sky, opacity, solid * (1 - opacity))
    return torch.where(is_valid, wrong, 0.0).sum() / is_valid.sum().clamp_min(1)


def sky_depth_loss(
    depths: Float[Tensor, "n"], is_visible: Bool[Tensor, "n"], num_foreground: int, gamma: float
) -> Float[Tensor, ""]:
    """``exp(-gamma (mean sky depth - mean foreground depth))``; 0 where a set is not visible.

    Args:
        depths: Camera z of all Gaussians, foreground first. The foreground gets no gradient.
        is_visible: Whether each Gaussian shows in this view.
        num_foreground: How many of them are foreground.
        gamma: How fast the loss falls with the distance, per world unit.
    """
    front, back = is_visible[:num_foreground], is_visible[num_foreground:]
    if not bool(front.any()) or not bool(back.any()):
        return depths.sum() * 0.0
    foreground = depths[:num_foreground].detach()[front].mean()
    sky = depths[num_foreground:][back].mean()
    return torch.exp(-gamma * (sky - foreground))
