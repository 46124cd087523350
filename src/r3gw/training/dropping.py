"""Leaving out some of the foreground in each iteration (beyond the paper).

Where few photos look, Gaussians before a lens explain a photo as well as the surface behind them,
which then gets no gradient. With a random part of the Gaussians missing, what lies behind must look
right too: DropGaussian (Park et al., CVPR 2025), dropout for Gaussians.
"""

from dataclasses import replace

import torch

from r3gw.imaging.colour import two_way_clamp
from r3gw.rendering.splat_set import Splats

LARGEST_OPACITY = 0.99


def dropped(splats: Splats, share: float, generator: torch.Generator) -> Splats:
    """The same Gaussians, a random ``share`` of the foreground with opacity 0.

    The others are more opaque by ``1 / (1 - share)``, so that the picture is about as dense.

    Args:
        splats: Foreground first; the sky stays whole.
        share: At least 0 and less than 1; 0 changes nothing and draws nothing.
        generator: Draws who is missing, on the CPU.
    """
    if share == 0:
        return splats
    num_foreground = len(splats.smallest_scales)
    is_kept = torch.rand(num_foreground, generator=generator) >= share
    factors = torch.ones(len(splats.opacities))
    factors[:num_foreground] = is_kept / (1 - share)
    opacities = splats.opacities * factors.to(splats.opacities)
    return replace(splats, opacities=two_way_clamp(opacities, 0.0, LARGEST_OPACITY))


def share_at(iteration: int, iterations: int, last: float) -> float:
    """Share that is dropped in an iteration: it grows evenly to ``last``."""
    return last * iteration / iterations
