"""Values where none were found: a smooth surface through those that were."""

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import avg_pool2d, interpolate, pad


def completed(values: Float[Tensor, "h w"], weights: Float[Tensor, "h w"]) -> Float[Tensor, "h w"]:
    """Fill values of weight 0 from coarser and coarser means ("pull-push", Gortler et al. 1996).

    Args:
        values: What is known; where the weight is 0 they do not matter.
        weights: 1 where a value is known, else 0; at least one is 1.
    """
    height, width = values.shape
    if height == width == 1:
        return values
    even = (0, width % 2, 0, height % 2)
    share = avg_pool2d(pad(weights[None], even), 2)[0]
    means = avg_pool2d(pad((values * weights)[None], even), 2)[0] / share.clamp_min(1e-9)
    coarse = completed(torch.where(share > 0, means, 0.0), (share > 0).to(values))
    size = (height + height % 2, width + width % 2)
    smooth = interpolate(coarse[None, None], size=size, mode="bilinear", align_corners=False)
    return torch.where(weights > 0, values, smooth[0, 0, :height, :width])
