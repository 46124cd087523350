"""The documented entry to the C++ rasterizer."""

from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.
from r3gw.raster import validation
from r3gw.raster.result import RasterResult


def rasterize(
    means: Float[Tensor, "n 3"],
    quaternions: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, " n"],
    features: Float[Tensor, "n channels"],
    cam_from_world: Float[Tensor, "rows 4"],
    intrinsics: Sequence[float] | Float[Tensor, "4"],
    width: int,
    height: int,
    background: Float[Tensor, " channels"] | None = None,
    *,
    num_feature_gradients: int | None = None,
) -> RasterResult:
    """Composite Gaussians front to back into an image of feature channels.

    EWA projection (Zwicker et al. 2002) with a low-pass of 0.3 px²; the Jacobian's x/z and y/z are
    held within the frustum widened by 15 % of the image on each side. Gaussians nearer than 0.01
    and those whose projected covariance overflows float32 are not visible. Alpha is clamped at
    0.99, alphas under 1/255 are skipped, and a pixel whose transmittance has fallen below 1e-4
    takes no more. Gaussians are ordered by camera z, equal depths by index.

    Results, gradients included, do not depend on ``torch.get_num_threads()``.

    Args:
        means: World positions.
        quaternions: Gaussian to world, wxyz, of any length > 0.
        scales: Standard deviations along the Gaussian's axes, world units, >= 0.
        opacities: Opacities in [0, 1].
        features: Any number of channels >= 1; 1, 3, 4, 8, 9 and 16 have kernels of their own.
        cam_from_world: [4, 4] or [3, 4]; x right, y down, z forward. Carries no gradient.
        intrinsics: (fx, fy, cx, cy) in pixels; pixel centres lie at +0.5.
        width: Image width in pixels.
        height: Image height in pixels.
        background: What shows through, zeros if None.
        num_feature_gradients: Only the first so many channels send a gradient to `features` (the
            others get zeros); every channel sends one to geometry and opacity. None: all.

    Raises:
        ValueError: For a wrong shape or dtype, and for parameters that are NaN, infinite or out of
            range; the message names the tensor and the number of values.
    """
    channels = features.shape[-1]
    intrinsics = [float(value) for value in intrinsics]
    parameters = means, quaternions, scales, opacities, features, background
    view = cam_from_world, intrinsics, width, height
    if not torch.ops.r3gw.is_usable(*parameters, *view):
        validation.check(*parameters, *view)
    columns = channels if num_feature_gradients is None else num_feature_gradients
    if not 0 <= columns <= channels:
        raise ValueError(f"num_feature_gradients must be in 0..{channels}, got {columns}")
    planes, alpha, radii_px, means2d = torch.ops.r3gw.rasterize(*parameters, *view, columns)
    return RasterResult(planes=planes, alpha=alpha, radii_px=radii_px, means2d=means2d)
