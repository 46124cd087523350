"""The Gaussians of a page, as the textures that its shaders read (web/src/splats.ts).

Every texture is `TEXTURE_WIDTH` texels wide; Gaussian ``i`` is texel ``i``, rows are filled up with
zeros. Axes of each Gaussian are put in an order that makes the third the shortest: its direction
is the normal, so normals need no room of their own.
"""

from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from torch import Tensor

from r3gw.imaging.colour import GAMMA
from r3gw.relight.gaussians import Relightable

TEXTURE_WIDTH = 2048
TRANSFER_LAYERS = 7  # of four coefficients each: 25 of SH degree 4, and three spare
QUATERNION_STEPS, TRANSFER_STEPS, BYTE_STEPS = 32767, 127, 255
TRANSFER_ZERO = 128
FLATTEST_LOG_SCALE = -16.0  # far below any pixel; keeps half floats and exp() in range


@dataclass(frozen=True)
class Buffers:
    """Textures as little-endian bytes.

    Attributes:
        place: ``[rows, 2048, 4]`` float32: position in the world, opacity.
        shape: ``[rows, 2048, 4]`` uint32: quaternion xyzw as 16-bit signed fractions, log scales as
            half floats, the last half unused.
        surface: ``[rows, 2048, 4]`` uint8: albedo to the power 1/2.2, roughness.
        transfer: ``[7, rows, 2048, 4]`` uint8 of `TRANSFER_ZERO` + 127 t / scale; None without
            shadows.
        transfer_scale: ``[28]`` largest absolute value per coefficient.
    """

    place: NDArray[np.float32]
    shape: NDArray[np.uint32]
    surface: NDArray[np.uint8]
    transfer: NDArray[np.uint8] | None
    transfer_scale: NDArray[np.float32]


def most_important(gaussians: Relightable, most: int) -> Relightable:
    """At most ``most`` Gaussians: all of the sky's, and the foreground's that cover most.

    Importance is opacity times the area of the two longer axes, which is what a Gaussian covers
    when it is looked at from the front.

    Args:
        gaussians: The scene; returned as it is if it is small enough.
        most: Limit; the sky's Gaussians count, but none of them is left out.
    """
    room = max(most - gaussians.num_sky, 0)
    if gaussians.num_foreground <= room:
        return gaussians
    count = gaussians.num_foreground
    longer = gaussians.log_scales[:count].sort(dim=-1, descending=True).values[:, :2].sum(-1)
    cover = gaussians.opacities[:count].log() + longer
    kept = cover.topk(room).indices.sort().values
    both = torch.cat([kept, torch.arange(count, len(gaussians.means))])
    occlusion = gaussians.occlusion
    return replace(
        gaussians,
        means=gaussians.means[both],
        quaternions=gaussians.quaternions[both],
        log_scales=gaussians.log_scales[both],
        opacity_logits=gaussians.opacity_logits[both],
        albedo=gaussians.albedo[kept],
        roughness=gaussians.roughness[kept],
        occlusion=None if occlusion is None else occlusion[kept],
    )


def buffers_of(gaussians: Relightable) -> Buffers:
    """Pack a scene; what rounding costs is held by tests/view/test_buffers.py."""
    quaternions, log_scales = shortest_last(gaussians.quaternions, gaussians.log_scales)
    place = torch.cat([gaussians.means, gaussians.opacities[:, None]], dim=-1).numpy()
    fractions = np.rint(quaternions * QUATERNION_STEPS).astype("<i2").view("<u2")
    logs = np.maximum(log_scales, FLATTEST_LOG_SCALE)
    halves = np.pad(logs, ((0, 0), (0, 1))).astype("<f2").view("<u2")
    words = np.concatenate([fractions, halves], axis=1)
    shape = np.ascontiguousarray(words).view("<u4")
    roughness = gaussians.roughness[:, None].numpy()
    surface = np.concatenate([gaussians.albedo.numpy() ** (1 / GAMMA), roughness], axis=1)
    levels = np.rint(surface * BYTE_STEPS).astype(np.uint8)
    transfer, scale = _transfer(gaussians)
    count = len(gaussians.means)
    return Buffers(
        _rows(place.astype("<f4"), count),
        _rows(shape, count),
        _rows(levels, count),
        transfer,
        scale,
    )


def shortest_last(
    quaternions: Float[Tensor, "n 4"], log_scales: Float[Tensor, "n 3"]
) -> tuple[Float[np.ndarray, "n 4"], Float[np.ndarray, "n 3"]]:
    """The same ellipsoids with axes in an order that puts the shortest last.

    Args:
        quaternions: wxyz, any length > 0.
        log_scales: Logarithms of the axes' standard deviations.

    Returns:
        Unit quaternions **xyzw** with w >= 0, and log scales.
    """
    scales = log_scales.double().numpy()
    rotations = Rotation.from_quat(quaternions.double().numpy(), scalar_first=True).as_matrix()
    # A cyclic shift of the axes is a rotation, so handedness is kept.
    shift = (np.argmin(scales, axis=1)[:, None] + np.arange(1, 4)) % 3
    turned = np.take_along_axis(rotations, shift[:, None, :], axis=2)
    found = Rotation.from_matrix(turned).as_quat(canonical=True)
    return found, np.take_along_axis(scales, shift, axis=1)


def _transfer(gaussians: Relightable) -> tuple[NDArray[np.uint8] | None, NDArray[np.float32]]:
    width = 4 * TRANSFER_LAYERS
    if gaussians.occlusion is None:
        return None, np.zeros(width, np.float32)
    values = gaussians.occlusion.numpy()
    padded = np.pad(values, ((0, 0), (0, width - values.shape[1])))
    scale = np.maximum(np.abs(padded).max(axis=0, initial=0.0), 1e-12).astype(np.float32)
    levels = (np.rint(padded / scale * TRANSFER_STEPS) + TRANSFER_ZERO).astype(np.uint8)
    count = len(gaussians.means)
    layers = [_rows(levels[:, 4 * i : 4 * i + 4], count) for i in range(TRANSFER_LAYERS)]
    return np.stack(layers), scale


def _rows(values: NDArray[Any], count: int) -> NDArray[Any]:
    """Rows of a texture that holds ``count`` texels, zeros behind the given values."""
    height = max(1, ceil(count / TEXTURE_WIDTH))
    texels = np.zeros((height * TEXTURE_WIDTH, 4), values.dtype)
    texels[: len(values)] = values
    return texels.reshape(height, TEXTURE_WIDTH, 4)
