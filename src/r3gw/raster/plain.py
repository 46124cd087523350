"""The backend ``torch``: the reference rasterizer behind the same checks as every backend."""

from collections.abc import Sequence

import torch
from torch import Tensor

from r3gw.raster import reference, validation
from r3gw.raster.result import RasterResult


def rasterize(
    means: Tensor,
    quaternions: Tensor,
    scales: Tensor,
    opacities: Tensor,
    features: Tensor,
    cam_from_world: Tensor,
    intrinsics: Sequence[float],
    width: int,
    height: int,
    background: Tensor | None,
    num_feature_gradients: int,
    pulls2d: Tensor | None,
) -> RasterResult:
    """See `r3gw.raster.rasterize`; every Gaussian meets every pixel.

    Raises:
        ValueError: For a wrong shape, dtype or device, and for parameters that are NaN, infinite or
            out of range.
    """
    gaussians = means, quaternions, scales, opacities, features
    view = cam_from_world, intrinsics, width, height
    validation.check(*gaussians, background, *view)
    learned, fixed = features.tensor_split([num_feature_gradients], dim=1)
    features = torch.cat([learned, fixed.detach()], dim=1)
    return reference.rasterize(*gaussians[:-1], features, *view, background, pulls2d)
