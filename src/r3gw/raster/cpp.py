"""The backend ``cpp``: the C++ kernels, for float32 tensors on the CPU."""

from collections.abc import Sequence

import torch
from torch import Tensor

from r3gw.native import ops
from r3gw.raster import validation
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
    """See `r3gw.raster.rasterize`. One pass in C++ tells whether anything is wrong.

    Raises:
        ValueError: If it is; also for tensors that are not float32 on the CPU.
    """
    gaussians = means, quaternions, scales, opacities, features, background
    view = cam_from_world, intrinsics, width, height
    tensors = [tensor for tensor in (*gaussians, cam_from_world) if tensor is not None]
    on_cpu = all(tensor.device.type == "cpu" for tensor in tensors)
    if not (on_cpu and ops.is_usable(*gaussians, *view)):
        validation.check_kind(means, torch.float32, "cpu")
        validation.check(*gaussians, *view)
    return RasterResult(*ops.rasterize(*gaussians, *view, num_feature_gradients, pulls2d))
