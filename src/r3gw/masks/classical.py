"""Sky segmentation without weights: a smooth region at the top, refined by GrabCut.

1. Regions of small gradient that touch the top edge, for a row of gradient thresholds, as in [1]
   but connected instead of column by column. The likeliest wins: two normal distributions of
   colour, and sky more probable the higher a pixel lies. What stands out among them is dropped
   (r3gw.masks.regions): leaves, poles and walls. Where the winner leaks into the building, stricter
   thresholds do not: the strictest region that is still large is sure sky.
2. So are clouds: brighter parts of the region that the energy of [1] prefers (it likes to take in
   clouds, and leaks) that are blue or white, and of the likeliest one that are not warm or that no
   edge as strong as the skyline's cuts off.
3. GrabCut [2] learns both colours and grows the sky; only parts connected to sure sky stay.
4. Near the skyline the colours around each pixel decide (r3gw.masks.skyline): holes in trees
   become sky, pale cornices and crosses become ground.

It takes for granted that a photo shows sky at its top edge; a smooth wall there is taken for sky
if no points are known on it.

[1] Shen and Wang, "Sky region detection in a single image for autonomous ground robot
navigation", IJARS 10, 2013.  [2] Rother, Kolmogorov and Blake, "GrabCut", SIGGRAPH 2004.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from r3gw.masks.regions import Counts, Cues, Mask, Rgb, smooth_top
from r3gw.masks.skyline import refine_skyline
from r3gw.masks.solid import Positions

_WORKING_PX = 512
# Gradient magnitudes (Sobel, 8-bit L*a*b*) tried as the border between smooth and not.
_THRESHOLDS = np.geomspace(12.0, 300.0, 24)
_SHARES = (0.05, 0.9)  # of the picture; other regions are no candidates for the sky
_COLOUR_FLOOR = 4.0  # squared 8-bit levels, added to the variances
_HORIZON = 0.55  # fraction of the height at which sky and ground are equally probable
_HORIZON_SLOPE = 4.0  # of the log odds of sky, per height
_STRICT_SHARE = 0.75  # of the winner's area that the strict region must keep
_CLOUD = 0.95  # times the sure sky's median brightness
_WARM = 130.0  # 8-bit b* of a colour just warmer than grey
_BLUE = 122.0  # 8-bit b* of a colour that stone does not have
_WHITE = 220.0  # 8-bit brightness of a sunlit cloud
_CLOUD_EDGE = 0.35  # times the skyline's median gradient
_GROUND_ROWS = 0.04  # of the height, at the bottom: never sky
_GRABCUT_ROUNDS = 5
# Where the brightest hundredth of a photo is darker than _NIGHT, it is made as bright as _DAY.
_BRIGHTEST, _NIGHT, _DAY = 0.99, 100.0, 220.0


@dataclass(frozen=True)
class _Candidate:
    """The sky by one threshold, and how well it splits the picture by two measures."""

    is_sky: Mask
    likelihood: float
    evenness: float


def segment_sky(photo: Rgb, solid: Positions | None = None) -> Mask:
    """Guess which pixels of an RGB photo ``[H, W, 3]`` show sky, ``[H, W]``.

    The same photo gives the same mask. All False if nothing at the top edge is smooth.

    Args:
        photo: The photo.
        solid: Where points of its surfaces lie in it (r3gw.masks.solid); None if unknown.
    """
    photo = _lightened(photo)
    height, width = photo.shape[:2]
    factor = _WORKING_PX / max(height, width)
    size = (max(1, round(width * factor)), max(1, round(height * factor)))
    interpolation = cv2.INTER_AREA if factor < 1.0 else cv2.INTER_CUBIC
    small = cv2.resize(photo, size, interpolation=interpolation).astype(np.uint8)
    points = _point_counts(solid, factor, size)
    sure = _sure_sky(small, points)
    if sure is None:
        return np.zeros((height, width), dtype=np.bool_)
    return refine_skyline(photo, _grown(small, sure))


def _lightened(photo: Rgb) -> Rgb:
    """A dark photo with the contrast of a bright one: the thresholds here are 8-bit levels."""
    brightest = float(np.quantile(photo.max(axis=2), _BRIGHTEST))
    if brightest >= _NIGHT:
        return photo
    return np.asarray(np.clip(photo * (_DAY / max(brightest, 1.0)), 0, 255).astype(np.uint8))


def _point_counts(solid: Positions | None, factor: float, size: tuple[int, int]) -> Counts:
    """How many points lie in each pixel of the picture scaled to ``size`` (width, height)."""
    width, height = size
    counts = np.zeros((height, width), np.int64)
    if solid is not None:
        column, row = np.floor(solid * factor).astype(np.int64).T
        np.add.at(counts, (row.clip(0, height - 1), column.clip(0, width - 1)), 1)
    return counts


def _sure_sky(photo: Rgb, points: Counts) -> Mask | None:
    """A region that is sky with hardly a doubt, or None if there is no candidate."""
    cues = Cues.of(photo, points)
    brightness = cues.brightness
    gradient = cv2.dilate(cues.gradient, np.ones((3, 3), np.uint8))
    colours, candidates = _Colours(photo), []
    for threshold in _THRESHOLDS:
        is_sky = smooth_top(gradient < threshold, cues)
        if _SHARES[0] <= is_sky.mean() <= _SHARES[1]:
            both = colours.covariances(is_sky)
            scores = _likelihood(is_sky, *both), _evenness(*both)
            candidates.append(_Candidate(is_sky, *scores))
    if not candidates:
        return None
    best = max(candidates, key=lambda candidate: candidate.likelihood)
    wanted = _STRICT_SHARE * best.is_sky.sum()
    strict = next(c.is_sky for c in candidates if c.is_sky.sum() >= wanted)
    smoothed = cv2.GaussianBlur(brightness, (0, 0), 2.0)
    wide = max(candidates, key=lambda candidate: candidate.evenness).is_sky
    is_bright = smoothed >= _CLOUD * np.median(smoothed[strict])
    below = cv2.dilate(best.is_sky.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(np.bool_)
    skyline = float(np.median(gradient[below & ~best.is_sky]))
    is_soft = gradient < _CLOUD_EDGE * skyline
    clouds = _clouds(photo, best.is_sky & is_bright & ~strict, strict, is_soft)
    is_pale = is_bright & _blue_or_white(photo)
    clouds |= _clouds(photo, wide & is_pale & ~strict, strict, is_soft)
    return np.asarray(strict | clouds)


def _blue_or_white(photo: Rgb) -> Mask:
    """Pixels whose surroundings are blue, or bright and not warm."""
    smoothed = cv2.GaussianBlur(photo, (0, 0), 2.0).astype(np.uint8)
    warmth = cv2.cvtColor(smoothed, cv2.COLOR_RGB2LAB)[..., 2]
    is_white = (smoothed.max(axis=2) >= _WHITE) & (warmth < _WARM)
    return np.asarray((warmth < _BLUE) | is_white)


def _clouds(photo: Rgb, parts: Mask, anchor: Mask, is_soft: Mask) -> Mask:
    """Those connected parts that are not warm, or whose border with ``anchor`` is mostly soft."""
    kernel = np.ones((5, 5), np.uint8)
    near = cv2.dilate(anchor.astype(np.uint8), kernel).astype(np.bool_)
    warmth = cv2.cvtColor(photo, cv2.COLOR_RGB2LAB)[..., 2]
    clouds = np.zeros(parts.shape, dtype=np.bool_)
    count, labels = cv2.connectedComponents(parts.astype(np.uint8), connectivity=4)
    for label in range(1, count):
        part = labels == label
        border = near & cv2.dilate(part.astype(np.uint8), kernel).astype(np.bool_)
        soft = bool(border.any()) and is_soft[border].mean() > 0.5
        if soft or warmth[part].mean() < _WARM:
            clouds |= part
    return clouds


class _Colours:
    """Sums over a photo's pixels, from which the covariance of any region follows quickly."""

    def __init__(self, photo: Rgb) -> None:
        colours = photo.reshape(-1, 3).astype(np.float64)
        ones = np.ones((len(colours), 1))
        products = (colours[:, :, None] * colours[:, None, :]).reshape(-1, 9)
        self._columns = np.ascontiguousarray(np.hstack([ones, colours, products]).T)
        self._total = self._columns.sum(axis=1)

    def covariances(self, is_sky: Mask) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Covariances ``[3, 3]`` of the colours of sky and ground, both not empty."""
        sky = self._columns @ is_sky.ravel().astype(np.float64)
        return _covariance(sky), _covariance(self._total - sky)


def _covariance(sums: NDArray[np.float64]) -> NDArray[np.float64]:
    mean = sums[1:4] / sums[0]
    return np.asarray(sums[4:].reshape(3, 3) / sums[0] - np.outer(mean, mean))


def _evenness(sky: NDArray[np.float64], ground: NDArray[np.float64]) -> float:
    """Energy of [1]: large where both covariances are small, the sky's counted double."""
    spread = 2.0 * np.linalg.det(sky) + np.linalg.det(ground)
    spread += 2.0 * np.linalg.eigvalsh(sky)[-1] + np.linalg.eigvalsh(ground)[-1]
    return float(1.0 / max(spread, 1e-12))


def _likelihood(is_sky: Mask, sky: NDArray[np.float64], ground: NDArray[np.float64]) -> float:
    """Log likelihood per pixel of a split, up to a constant (step 1)."""
    height = len(is_sky)
    odds = _HORIZON_SLOPE * (_HORIZON - (np.arange(height) + 0.5) / height)
    share = is_sky.mean(axis=1)  # of each row
    total = -float(np.mean(share * np.logaddexp(0, -odds) + (1 - share) * np.logaddexp(0, odds)))
    for weight, covariance in ((is_sky.mean(), sky), (1.0 - is_sky.mean(), ground)):
        floored = covariance + _COLOUR_FLOOR * np.eye(3)
        total -= 0.5 * float(weight * np.linalg.slogdet(floored)[1])
    return total


def _grown(photo: Rgb, sure: Mask) -> Mask:
    """GrabCut from the sure sky; keeps what is connected to its core."""
    core = cv2.erode(sure.astype(np.uint8), np.ones((9, 9), np.uint8)).astype(np.bool_)
    labels = np.where(sure, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    labels[core] = cv2.GC_FGD
    labels[round((1.0 - _GROUND_ROWS) * len(labels)) :] = cv2.GC_BGD
    if not core.any():
        return sure
    cv2.setRNGSeed(0)  # GrabCut starts its colour mixtures by k-means
    sky_model, ground_model = np.zeros((1, 65)), np.zeros((1, 65))
    mode, no_frame = cv2.GC_INIT_WITH_MASK, (0, 0, 0, 0)
    cv2.grabCut(photo, labels, no_frame, ground_model, sky_model, _GRABCUT_ROUNDS, mode)
    is_sky = (labels == cv2.GC_FGD) | (labels == cv2.GC_PR_FGD)
    _, regions = cv2.connectedComponents(is_sky.astype(np.uint8), connectivity=4)
    return np.isin(regions, np.setdiff1d(regions[core], [0]))
