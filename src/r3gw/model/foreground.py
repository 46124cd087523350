"""Foreground Gaussians: geometry, albedo and roughness, stored before their activations."""

import numpy as np
import torch
from jaxtyping import Bool, Float
from scipy.spatial import cKDTree
from torch import Tensor

from r3gw.model.rows import Rows
from r3gw.model.settings import InitSettings

PREFIX = "foreground."


def initial_foreground(xyz: Float[Tensor, "n 3"], init: InitSettings) -> Rows:
    """Gaussians at the sparse points (method 8): isotropic, random-free, uniform material."""
    count = len(xyz)
    opacity = torch.full((count,), init.opacity)
    return Rows(
        PREFIX,
        {
            "means": xyz.clone(),
            "log_scales": initial_log_scales(xyz),
            "quaternions": torch.tensor([1.0, 0.0, 0.0, 0.0]).repeat(count, 1),
            "opacity_logits": torch.logit(opacity),
            "albedo_logits": torch.logit(torch.full((count, 3), init.albedo)),
            "roughness_logits": torch.logit(torch.full((count,), init.roughness)),
        },
    )


def initial_log_scales(xyz: Float[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
    """Log of the mean distance to the 3 nearest neighbours, the same for all axes.

    Fewer than 4 points take what neighbours there are; a lone point gets scale 0.1.
    """
    neighbours = min(3, len(xyz) - 1)
    if neighbours < 1:
        return torch.full((len(xyz), 3), 0.1).log()
    points = xyz.double().numpy()
    distances = np.asarray(cKDTree(points).query(points, k=neighbours + 1)[0])
    mean = torch.from_numpy(distances[:, 1:].mean(axis=1)).float().clamp_min(1e-6)
    return mean.log()[:, None].repeat(1, 3)


def too_large(log_scales: Float[Tensor, "n 3"], limit: float) -> Bool[Tensor, "n"]:
    """True where a Gaussian's largest scale exceeds ``limit`` (world units)."""
    return log_scales.detach().exp().amax(dim=-1) > limit
