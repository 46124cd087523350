"""The operators of the compiled extension, with types: the one place that calls torch.ops.r3gw.

Every operator has a schema, and an implementation per device (so far the CPU) that stands beside
its kernel, in csrc of the package whose plain form it replaces. Torch refuses tensors of a device
without one; `r3gw.native.kernels.take` tells beforehand. Tensors are contiguous float32 unless said
otherwise; shapes are those of the callers, which document them.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import torch
from torch import Tensor

import r3gw.native.extension  # noqa: F401  Registers torch.ops.r3gw.

_ops: Any = torch.ops.r3gw


class ForegroundRows(NamedTuple):
    """Stored parameters of the foreground; ``shadow`` is what shadows change in the irradiance."""

    means: Tensor
    log_scales: Tensor
    quaternions: Tensor
    opacity_logits: Tensor
    albedo_logits: Tensor
    roughness_logits: Tensor
    shadow: Tensor | None


class SkyRows(NamedTuple):
    """Stored parameters of the sky; one radius and one centre for all."""

    angles: Tensor
    log_scales: Tensor
    quaternions: Tensor
    opacity_logits: Tensor
    radius: Tensor
    centre: Tensor


class SplatRows(NamedTuple):
    """Gaussians of both sets as the rasterizer takes them, foreground first."""

    means: Tensor
    quaternions: Tensor
    scales: Tensor
    opacities: Tensor
    features: Tensor
    depths: Tensor
    smallest_scales: Tensor


class Rasterized(NamedTuple):
    """Composited planes and alpha; radii and projected means of the Gaussians."""

    planes: Tensor
    alpha: Tensor
    radii_px: Tensor
    means2d: Tensor


class PictureTerms(NamedTuple):
    """Losses of a picture in the order of their weights; gradients of their weighted sum."""

    losses: list[float]
    by_planes: Tensor
    by_alpha: Tensor


def keep_freed_memory() -> None:
    """Keep freed memory with the process, for programs that allocate the same sizes again."""
    _ops.keep_freed_memory()


def is_usable(
    means: Tensor,
    quaternions: Tensor,
    scales: Tensor,
    opacities: Tensor,
    features: Tensor,
    background: Tensor | None,
    cam_from_world: Tensor,
    intrinsics: Sequence[float],
    width: int,
    height: int,
) -> bool:
    """Whether `rasterize` takes these arguments: `r3gw.raster.validation` in one pass."""
    gaussians = (means, quaternions, scales, opacities, features, background)
    return bool(_ops.is_usable(*gaussians, cam_from_world, intrinsics, width, height))


def rasterize(
    means: Tensor,
    quaternions: Tensor,
    scales: Tensor,
    opacities: Tensor,
    features: Tensor,
    background: Tensor | None,
    cam_from_world: Tensor,
    intrinsics: Sequence[float],
    width: int,
    height: int,
    num_feature_gradients: int,
    pulls2d: Tensor | None,
) -> Rasterized:
    """See `r3gw.raster.rasterize`; arguments are not checked. Differentiable; any strides."""
    gaussians = (means, quaternions, scales, opacities, features, background)
    view = (cam_from_world, intrinsics, width, height)
    return Rasterized(*_ops.rasterize(*gaussians, *view, num_feature_gradients, pulls2d))


def rendered_channels() -> list[tuple[str, int, bool]]:
    """Name, number of columns and whether it is learned, of every channel in order."""
    names, widths, learned = _ops.rendered_channels()
    return [
        (name, width, bool(flag)) for name, width, flag in zip(names, widths, learned, strict=True)
    ]


def splats(
    foreground: ForegroundRows,
    sky: SkyRows,
    light: Tensor,
    table: Tensor | None,
    sky_light: Tensor | None,
    cam_from_world: Tensor,
    layers: int,
) -> SplatRows:
    """See `r3gw.rendering.splats.splats_of`. Differentiable in all but ``table`` and the camera.

    Args:
        foreground, sky: Stored parameters.
        light: SH coefficients, degree 2 or 4.
        table: `r3gw.rendering.brdf_table`; None: no specular.
        sky_light: Sky coefficients; None: a white sky.
        cam_from_world: float64, ``[4, 4]``, on the CPU whatever the device.
        layers: `r3gw.rendering.channels.Layers`.
    """
    named = {f"sky_{name}": value for name, value in sky._asdict().items()}
    return SplatRows(
        *_ops.splats(
            **foreground._asdict(),
            **named,
            light=light,
            table=table,
            sky_light=sky_light,
            cam_from_world=cam_from_world,
            layers=layers,
        )
    )


def shade(
    normals: Tensor,
    to_camera: Tensor,
    albedo: Tensor,
    roughness: Tensor,
    light: Tensor,
    table: Tensor | None,
) -> Tensor:
    """See `r3gw.rendering.cook_torrance.shade`; SH degree 2 or 4, any strides, no gradient."""
    colours: Tensor = _ops.shade(normals, to_camera, albedo, roughness, light, table)
    return colours


def appearance(
    embedding: Tensor,
    row: int,
    dropout: Tensor | None,
    weights: Sequence[Tensor],
    biases: Sequence[Tensor],
) -> tuple[Tensor, Tensor]:
    """Light and sky coefficients of a row of the embedding (r3gw.model.appearance).

    Differentiable.

    Args:
        embedding: A row per light.
        row: Whose light.
        dropout: Factors on the first layer's output; None: all 1.
        weights, biases: Of the six layers: the trunk's three, the sky's head, the light's two.
    """
    light, sky = _ops.appearance(embedding, row, dropout, weights, biases)
    return light, sky


def picture_losses(
    planes: Tensor,
    alpha: Tensor,
    target: Tensor,
    is_valid: Tensor,
    is_sky: Tensor,
    weights: Sequence[float],
    solid: float,
    intrinsics: Sequence[float],
    cam_from_world: Tensor,
) -> PictureTerms:
    """See `r3gw.training.losses.fused.picture`; a loss of weight 0 is not computed.

    Args:
        planes, alpha: What was rendered.
        target: uint8.
        is_valid, is_sky: Masks.
        weights: L1, 1 - SSIM, normals, Eq. 15, silhouette.
        solid: How much the silhouette asks of pixels that are not sky.
        intrinsics, cam_from_world: The camera's, the latter float64.
    """
    masks = (is_valid, is_sky)
    camera = (intrinsics, cam_from_world)
    return PictureTerms(
        *_ops.picture_losses(planes, alpha, target, *masks, weights, solid, *camera)
    )


def positivity(light: Tensor, directions: Tensor, weight: float) -> tuple[float, Tensor]:
    """Eq. 12 and the gradient of ``weight`` times it; SH degree 2 or 4."""
    value, gradient = _ops.positivity(light, directions, weight)
    return value, gradient


def flatness(smallest_scales: Tensor, radii_px: Tensor, weight: float) -> tuple[float, Tensor]:
    """Eq. 14 and the gradient of ``weight`` times it."""
    value, gradient = _ops.flatness(smallest_scales, radii_px, weight)
    return value, gradient


def sky_depth(
    depths: Tensor, radii_px: Tensor, num_foreground: int, gamma: float, weight: float
) -> tuple[float, Tensor]:
    """Eq. 16 and the gradient of ``weight`` times it."""
    value, gradient = _ops.sky_depth(depths, radii_px, num_foreground, gamma, weight)
    return value, gradient


def known_gradient(value: float, gradients: Sequence[Tensor], inputs: Sequence[Tensor]) -> Tensor:
    """A scalar whose gradients by ``inputs`` are known: one node of torch's graph, any device."""
    total: Tensor = _ops.known_gradient(value, gradients, inputs)
    return total


def adam_step(
    values: Sequence[Tensor],
    means: Sequence[Tensor],
    squares: Sequence[Tensor],
    steps: Sequence[Tensor],
    rates: Sequence[float],
    betas: tuple[float, float],
    epsilon: float,
) -> None:
    """See `r3gw.training.optimizer.adam_step`; in place, and takes the gradients away."""
    _ops.adam_step(values, means, squares, steps, rates, *betas, epsilon)


def add_gradient_norms(
    totals: Tensor, views: Tensor, gradient: Tensor, radii_px: Tensor, x: float, y: float
) -> None:
    """Add ``|(x g_x, y g_y)|`` to the totals and 1 to the views of visible Gaussians, in place."""
    _ops.add_gradient_norms(totals, views, gradient, radii_px, x, y)
