"""Smooth regions at a photo's top edge, without those that are no sky."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Rgb = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Counts = NDArray[np.int64]

_DARK = 0.72  # times the main region's brightness; darker ones at the top are no sky
# Brick in the sun is as bright as the sky, but warmer by so many 8-bit levels of b*, and rougher so
# many times, and by so many 8-bit levels. A sunset is as smooth as the rest of its sky.
_WARMER, _ROUGHER, _ROUGHER_BY = 30.0, 3.0, 8.0
# A region is none of the sky if it holds so many points, and so many for its size, as a share of
# what the whole picture holds. Those within a few pixels of its border may stand beside it.
_FEWEST_POINTS, _POINT_DENSITY, _BORDER_PX = 3, 0.1, 5


@dataclass(frozen=True)
class Cues:
    """What tells sky from what stands before it, by pixel.

    Attributes:
        brightness: Largest channel, 8-bit.
        warmth: b* of L*a*b*, 8-bit.
        gradient: Largest Sobel gradient over the L*a*b* channels.
        points: How many points of structure from motion lie there.
    """

    brightness: NDArray[np.float64]
    warmth: NDArray[np.float64]
    gradient: NDArray[np.float32]
    points: Counts

    @staticmethod
    def of(photo: Rgb, points: Counts) -> "Cues":
        """Cues of an RGB photo ``[H, W, 3]`` in which ``points`` are known."""
        lab = cv2.cvtColor(photo, cv2.COLOR_RGB2LAB).astype(np.float32)
        gradients = [
            np.hypot(cv2.Sobel(channel, cv2.CV_32F, 1, 0), cv2.Sobel(channel, cv2.CV_32F, 0, 1))
            for channel in cv2.split(lab)
        ]
        gradient = np.asarray(np.max(gradients, axis=0), dtype=np.float32)
        brightness = photo.max(axis=2).astype(np.float64)
        return Cues(brightness, lab[..., 2].astype(np.float64), gradient, points)


def smooth_top(is_smooth: Mask, cues: Cues) -> Mask:
    """Smooth regions that touch the top edge, without what stands out against the largest.

    Args:
        is_smooth: Where the dilated gradient is small, ``[H, W]``.
        cues: Of the same photo.
    """
    count, found = cv2.connectedComponents(is_smooth.astype(np.uint8), connectivity=4)
    labels = np.asarray(found, dtype=np.int32)
    area = np.maximum(np.bincount(labels.ravel(), minlength=count), 1)
    at_top = np.setdiff1d(labels[0], [0])
    at_top = at_top[~_are_solid(labels, area, cues.points)[at_top]]
    if at_top.size == 0:
        return np.zeros(is_smooth.shape, dtype=np.bool_)
    brightness, warmth, gradient = (
        np.bincount(labels.ravel(), values.ravel(), minlength=count) / area
        for values in (cues.brightness, cues.warmth, cues.gradient)
    )
    largest = at_top[area[at_top].argmax()]
    is_dark = brightness < _DARK * brightness[largest]
    is_warm = warmth > warmth[largest] + _WARMER
    is_rough = gradient > _ROUGHER * gradient[largest] + _ROUGHER_BY
    kept = np.isin(labels, at_top[~(is_dark | (is_warm & is_rough))[at_top]])
    # Give back the pixel that the dilated gradient took.
    return cv2.dilate(kept.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(np.bool_)


def _are_solid(labels: NDArray[np.int32], area: Counts, points: Counts) -> Mask:
    """Which regions hold so many points that they are none of the sky."""
    if not points.any():
        return np.zeros(len(area), dtype=np.bool_)
    kernel = np.ones((2 * _BORDER_PX + 1,) * 2, np.uint8)
    # Greatest and smallest label around a pixel agree inside of a region alone.
    as_float = labels.astype(np.float32)
    is_inside = cv2.dilate(as_float, kernel) == cv2.erode(as_float, kernel)
    held = np.bincount(labels.ravel(), (points * is_inside).ravel(), minlength=len(area))
    density = points.sum() / points.size
    return np.asarray((held >= _FEWEST_POINTS) & (held > _POINT_DENSITY * density * area))
