"""Procedural albedo textures: linear RGB ``[H, W, 3]``, tileable, row 0 at the bottom (v = 0)."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]
Colour = Sequence[float]

SIZE = 512


def noise(
    random: np.random.Generator, slope: float = 1.0, stretch: tuple[float, float] = (1.0, 1.0)
) -> NDArray[np.float64]:
    """Periodic noise ``[SIZE, SIZE]`` of mean 0 and deviation 1 with amplitude 1/frequency^slope.

    Args:
        random: Source of the noise.
        slope: 0 is white, 1 to 2 is cloudy.
        stretch: Along rows and columns; a larger value draws longer streaks along that axis.
    """
    rows = np.fft.fftfreq(SIZE)[:, None] * SIZE * stretch[0]
    columns = np.fft.rfftfreq(SIZE)[None, :] * SIZE * stretch[1]
    amplitude = 1.0 / np.maximum(np.hypot(rows, columns), 1.0) ** slope
    amplitude[0, 0] = 0.0
    spectrum = np.fft.rfft2(random.standard_normal((SIZE, SIZE))) * amplitude
    field = np.fft.irfft2(spectrum, s=(SIZE, SIZE))
    return np.asarray(field / field.std())


def blocks(
    random: np.random.Generator,
    colour: Colour,
    courses: int,
    per_course: int,
    *,
    joint: Colour,
    joint_px: int = 4,
    variation: float = 0.12,
    shift: float = 0.5,
) -> Image:
    """Masonry: courses of blocks with their own tints, mortar joints, weathering and streaks.

    Args:
        random: Source of tints and weathering.
        colour: Mean albedo of a block.
        courses: Rows of blocks per tile.
        per_course: Blocks per row.
        joint: Albedo of the mortar.
        joint_px: Width of a joint in texels.
        variation: Relative deviation of tint from block to block.
        shift: Offset of every other course, in blocks.
    """
    row, column = np.mgrid[0:SIZE, 0:SIZE]
    course = row * courses // SIZE
    along = column + (course % 2) * shift * SIZE / per_course
    block = np.floor(along * per_course / SIZE).astype(np.int64) % per_course
    tint = 1.0 + variation * random.standard_normal((courses, per_course, 1))
    hue = 1.0 + 0.25 * variation * random.standard_normal((courses, per_course, 3))
    albedo = (tint * hue)[course, block] * np.asarray(colour)
    in_row = row - course * SIZE / courses
    in_block = along % (SIZE / per_course)
    is_joint = (in_row < joint_px) | (in_block < joint_px)
    edge = cv2.GaussianBlur(is_joint.astype(np.float32), (0, 0), 1.2)[..., None]
    albedo = albedo * (1 - edge) + np.asarray(joint) * edge
    return weathered(random, albedo, 0.07, 0.05)


def weathered(
    random: np.random.Generator, albedo: NDArray[np.float64], grain: float, streaks: float
) -> Image:
    """Add grain and vertical streaks, in relative strength."""
    grime = noise(random, 0.7) * grain + noise(random, 1.2, (0.12, 1.0)) * streaks
    return np.clip(albedo * (1.0 + grime[..., None]), 0.02, 0.9).astype(np.float32)


def plaster(random: np.random.Generator, colour: Colour, stains: float = 0.07) -> Image:
    """Painted render with stains, run-off streaks and faded patches."""
    patches = np.clip(noise(random, 1.4), -2, 2)[..., None]
    fade = np.asarray(colour) * (1.0 + 0.06 * patches * np.array([1.0, 0.9, 0.7]))
    return weathered(random, fade, 0.04, stains)


def speckle(
    random: np.random.Generator, dark: Colour, light: Colour, slope: float = 0.8, bias: float = 0.5
) -> Image:
    """Mix two colours by noise: grass, gravel, foliage, bark."""
    mix = np.clip(bias + 0.22 * noise(random, slope), 0.0, 1.0)[..., None]
    patches = 1.0 + 0.1 * np.clip(noise(random, 1.6), -2, 2)[..., None]
    albedo = (np.asarray(dark) * (1 - mix) + np.asarray(light) * mix) * patches
    return np.clip(albedo, 0.01, 0.9).astype(np.float32)


def marble(random: np.random.Generator, colour: Colour, vein: Colour) -> Image:
    """Pale stone with thin veins along the zero line of noise."""
    line = np.exp(-((noise(random, 1.5) / 0.07) ** 2)) * np.clip(0.5 + noise(random, 1.6), 0, 1)
    mix = 0.55 * cv2.GaussianBlur(line, (0, 0), 1.5)[..., None]
    albedo = np.asarray(colour) * (1 - mix) + np.asarray(vein) * mix
    return weathered(random, albedo, 0.04, 0.05)


def planks(random: np.random.Generator, colour: Colour, count: int = 12) -> Image:
    """Upright wooden boards with grain."""
    board = np.arange(SIZE) * count // SIZE
    tint = 1.0 + 0.12 * random.standard_normal(count)[board][None, :, None]
    gap = (np.arange(SIZE) % (SIZE // count) < 3)[None, :, None]
    grain = 1.0 + 0.12 * noise(random, 1.0, (0.05, 1.0))[..., None]
    albedo = np.asarray(colour) * tint * grain * np.where(gap, 0.4, 1.0)
    return np.clip(albedo, 0.01, 0.9).astype(np.float32)
