"""The documented entry to the rasterizer."""

from collections.abc import Sequence

from jaxtyping import Float
from torch import Tensor

from r3gw.raster.backends import backend_named
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
    pulls2d: Float[Tensor, "n 2"] | None = None,
    backend: str | None = None,
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
        pulls2d: Zeros that require a gradient. They take no part in the picture; their ``.grad`` is
            that of the projected means, but pixels add up without their signs, so that those that
            pull in opposite directions do not cancel (Ye et al., 2024). Of more than 16 channels
            the backend ``cpp`` adds up the pulls of every 16. None: not computed.
        backend: ``cpp`` (float32 on the CPU), ``torch`` (the plain reference, for small scenes), or
            what `r3gw.raster.backends.register_backend` has added. None: ``cpp`` for tensors on the
            CPU; elsewhere what is registered for the device, or ``torch``.

    Raises:
        ValueError: For a wrong shape, dtype or device, for parameters that are NaN, infinite or out
            of range (the message names the tensor and the number of values), and for a backend that
            does not exist.
    """
    channels = features.shape[-1]
    columns = channels if num_feature_gradients is None else num_feature_gradients
    if not 0 <= columns <= channels:
        raise ValueError(f"num_feature_gradients must be in 0..{channels}, got {columns}")
    chosen = backend_named(backend, means.device)
    view = cam_from_world, [float(value) for value in intrinsics], width, height
    gaussians = means, quaternions, scales, opacities, features
    return chosen(*gaussians, *view, background, columns, pulls2d)
