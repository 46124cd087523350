"""Plain-torch rasterizer: the oracle that the C++ kernels are held against.

Same semantics as `r3gw.raster.rasterize` and the same result, in float32 or float64, with
gradients from autograd. Every Gaussian meets every pixel, so it is for small scenes.
"""

from collections.abc import Sequence

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.autograd.function import FunctionCtx

from r3gw.raster.result import RasterResult

NEAR_PLANE = 0.01
LOW_PASS_PX2 = 0.3
MAX_ALPHA = 0.99
MIN_ALPHA = 1 / 255
MIN_TRANSMITTANCE = 1e-4
FRUSTUM_MARGIN = 0.15


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
    pulls2d: Float[Tensor, "n 2"] | None = None,
) -> RasterResult:
    """Composite Gaussians front to back; arguments and result as of `r3gw.raster.rasterize`."""
    position = means @ cam_from_world[:3, :3].T + cam_from_world[:3, 3]
    covariance = _projected_covariance(
        position, quaternions, scales, cam_from_world, intrinsics, width, height
    )
    fx, fy, cx, cy = (float(value) for value in intrinsics)
    z = position[:, 2].clamp_min(NEAR_PLANE)
    means2d = torch.stack([fx * position[:, 0] / z + cx, fy * position[:, 1] / z + cy], dim=-1)
    radii, is_visible = _footprint(position[:, 2], means2d, covariance, opacities, width, height)
    means2d = torch.where(is_visible[:, None], means2d, 0)
    if means2d.requires_grad:
        means2d.retain_grad()

    drawn = torch.nonzero(is_visible)[:, 0]
    order = drawn[torch.sort(position[drawn, 2].detach(), stable=True).indices]
    if background is None:
        background = features.new_zeros(features.shape[1])
    conics = torch.linalg.inv(covariance[order])
    pulls2d = torch.zeros_like(means2d) if pulls2d is None else pulls2d
    drawn2d = means2d[order], pulls2d[order], conics
    rows = [
        _composite_row(y, width, *drawn2d, opacities[order], features[order]) for y in range(height)
    ]
    transmittance = torch.stack([row[1] for row in rows])
    image = torch.stack([row[0] for row in rows]) + transmittance[..., None] * background
    return RasterResult(
        planes=image.permute(2, 0, 1),
        alpha=1 - transmittance,
        radii_px=radii.detach(),
        means2d=means2d,
    )


def _projected_covariance(
    position: Float[Tensor, "n 3"],
    quaternions: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    cam_from_world: Float[Tensor, "rows 4"],
    intrinsics: Sequence[float] | Float[Tensor, "4"],
    width: int,
    height: int,
) -> Float[Tensor, "n 2 2"]:
    """J W Σ Wᵀ Jᵀ + low-pass (Zwicker et al. 2002, eq. 29 to 31), J held near the frustum."""
    fx, fy, cx, cy = (float(value) for value in intrinsics)
    margin_x, margin_y = FRUSTUM_MARGIN * width, FRUSTUM_MARGIN * height
    x, y, z = position.unbind(-1)
    z = z.clamp_min(NEAR_PLANE)
    slope_x = (x / z).clamp((-cx - margin_x) / fx, (width - cx + margin_x) / fx)
    slope_y = (y / z).clamp((-cy - margin_y) / fy, (height - cy + margin_y) / fy)
    zero = torch.zeros_like(z)
    jacobian = torch.stack(
        [fx / z, zero, -fx * slope_x / z, zero, fy / z, -fy * slope_y / z], dim=-1
    ).reshape(-1, 2, 3)
    axes = _rotations(quaternions) * scales[:, None, :]
    projected = jacobian @ cam_from_world[:3, :3] @ axes
    low_pass = LOW_PASS_PX2 * torch.eye(2, dtype=projected.dtype, device=projected.device)
    return projected @ projected.transpose(-1, -2) + low_pass


def _rotations(quaternions: Float[Tensor, "n 4"]) -> Float[Tensor, "n 3 3"]:
    """Rotation matrices of wxyz quaternions of any length, as I + 2w[v]× + 2[v]×²."""
    w, x, y, z = torch.nn.functional.normalize(quaternions, dim=-1).unbind(-1)
    zero = torch.zeros_like(w)
    cross = torch.stack([zero, -z, y, z, zero, -x, -y, x, zero], dim=-1).reshape(-1, 3, 3)
    identity = torch.eye(3, dtype=w.dtype, device=w.device)
    return identity + 2 * w[:, None, None] * cross + 2 * cross @ cross


def _footprint(
    depth: Float[Tensor, " n"],
    means2d: Float[Tensor, "n 2"],
    covariance: Float[Tensor, "n 2 2"],
    opacities: Float[Tensor, " n"],
    width: int,
    height: int,
) -> tuple[Float[Tensor, " n"], Bool[Tensor, " n"]]:
    """Radius in pixels (0 = not visible), and whether the Gaussian is visible."""
    exponent = torch.log(opacities / MIN_ALPHA).clamp_min(0)
    half = torch.sqrt(2 * exponent[:, None] * covariance.diagonal(dim1=-2, dim2=-1))
    size = means2d.new_tensor([width, height])
    is_inside = ((means2d + half >= 0) & (means2d - half <= size)).all(-1)
    is_visible = is_inside & (opacities >= MIN_ALPHA) & (depth >= NEAR_PLANE)
    return torch.where(is_visible, half.amax(-1), 0), is_visible


def _composite_row(
    y: int,
    width: int,
    means2d: Float[Tensor, "n 2"],
    pulls2d: Float[Tensor, "n 2"],
    conics: Float[Tensor, "n 2 2"],
    opacities: Float[Tensor, " n"],
    features: Float[Tensor, "n channels"],
) -> tuple[Float[Tensor, "width channels"], Float[Tensor, " width"]]:
    """One image row without its background, and its final transmittance."""
    x = torch.arange(width, dtype=means2d.dtype, device=means2d.device) + 0.5
    pixels = torch.stack([x, torch.full_like(x, y + 0.5)], dim=-1)
    repeated: Tensor = _ForEachPixel.apply(means2d, pulls2d, width)  # type: ignore[no-untyped-call]
    offset = pixels[:, None] - repeated
    power = -0.5 * torch.einsum("pni,nij,pnj->pn", offset, conics, offset)
    alpha = (opacities * torch.exp(power)).clamp_max(MAX_ALPHA)
    alpha = torch.where(alpha >= MIN_ALPHA, alpha, 0)
    is_open = _transmittance_before(alpha) >= MIN_TRANSMITTANCE
    alpha = torch.where(is_open, alpha, 0)
    weights = alpha * _transmittance_before(alpha)
    return weights @ features, torch.prod(1 - alpha, dim=-1)


class _ForEachPixel(torch.autograd.Function):
    """Means once per pixel; sums what pixels pull them by, and into pulls its absolute values."""

    @staticmethod
    def forward(
        _: FunctionCtx, means2d: Float[Tensor, "n 2"], __: Float[Tensor, "n 2"], pixels: int
    ) -> Float[Tensor, "p n 2"]:
        """Repeat the means."""
        return means2d.expand(pixels, -1, -1)

    @staticmethod
    def backward(
        _: FunctionCtx, gradient: Float[Tensor, "p n 2"]
    ) -> tuple[Float[Tensor, "n 2"], Float[Tensor, "n 2"], None]:
        """Sum over the pixels, with signs and without."""
        return gradient.sum(dim=0), gradient.abs().sum(dim=0), None


def _transmittance_before(alpha: Float[Tensor, "p n"]) -> Float[Tensor, "p n"]:
    """Product of 1 − alpha over the Gaussians in front, for each Gaussian."""
    passed = torch.cumprod(1 - alpha, dim=-1)
    return torch.cat([torch.ones_like(alpha[:, :1]), passed[:, :-1]], dim=-1)[:, : alpha.shape[1]]
