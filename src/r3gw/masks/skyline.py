"""The last step of the sky segmentation: every pixel near the skyline is decided by its colour.

Around each pixel, the colours of sure sky and of sure ground are two normal distributions in
L*a*b*, as in the local classifiers of Bai et al. ("Video SnapCut", SIGGRAPH 2009). Holes between
leaves and balusters, which no region that grows from the top can reach, become sky; pale cornices
and crosses, which GrabCut takes for cloud, become ground. Where both distributions are alike, a
pixel stays what it was.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

Rgb = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Lab = NDArray[np.float32]

_SIZE_PX = (512, 1024)  # longer side of the working picture: smaller photos, larger photos
# Lengths are fractions of the longer side.
_REACH = {"sky": 0.047, "ground": 0.031}  # standard deviation of the local statistics
_FAR_REACH = 0.19  # of those that take over where there is nothing sure nearby
_MARGIN = {"sky": 0.008, "ground": 0.004}  # what is nearer to the border is not sure
_BORDER = 0.016  # sky farther than this from ground stays sky
_HOLES = 0.12  # ground farther than this from sky stays ground
_FAR_WEIGHT = 1e-2
_EVERYWHERE_WEIGHT = 1e-5
_FLOOR = np.array([4.0, 3.0, 3.0], np.float32) ** 2  # added to the variances of L*, a*, b*
_HOLE_ODDS = 1.5  # log odds from which ground becomes sky
_HOLE_DISTANCE = 10.0  # squared, normalised: colours stranger to the sky stay ground
_GROUND_ODDS = 0.5  # log odds from which sky becomes ground
_GROUND_DISTANCE = 4.0  # squared, normalised: colours nearer to the sky's stay sky
_HORIZON_SHARE = 0.01  # of a row that is sky at least, where there is sky; no holes below
_ROUNDS = 2


def refine_skyline(photo: Rgb, is_sky: Mask) -> Mask:
    """Bring a coarse mask to the size of its photo, pixel by pixel near the skyline.

    Args:
        photo: RGB ``[H, W, 3]``.
        is_sky: Coarse mask ``[h, w]`` of any size.

    Returns:
        The mask ``[H, W]``; the same inputs give the same bytes.
    """
    height, width = photo.shape[:2]
    longest = min(max(max(height, width), _SIZE_PX[0]), _SIZE_PX[1])
    factor = longest / max(height, width)
    size = (max(1, round(width * factor)), max(1, round(height * factor)))
    filter_ = cv2.INTER_AREA if factor < 1.0 else cv2.INTER_CUBIC
    working = cv2.resize(photo, size, interpolation=filter_).astype(np.float32) / 255.0
    lab = cv2.cvtColor(working, cv2.COLOR_RGB2LAB).astype(np.float32)
    mask = _scaled(is_sky, size, cv2.INTER_LINEAR)
    for _ in range(_ROUNDS):
        if not mask.any() or mask.all():
            break
        mask = _decided(lab, mask, longest)
    return _scaled(mask, (width, height), cv2.INTER_LINEAR if factor < 1.0 else cv2.INTER_AREA)


def _decided(lab: Lab, is_sky: Mask, longest: int) -> Mask:
    """One round: both distributions from what is sure, then every doubtful pixel."""
    sky_distance, sky_spread = _fit(lab, is_sky, "sky", longest)
    ground_distance, ground_spread = _fit(lab, ~is_sky, "ground", longest)
    odds = 0.5 * (ground_distance + ground_spread - sky_distance - sky_spread)
    is_hole = ~is_sky & _grown(is_sky, _HOLES * longest)
    is_hole &= (odds > _HOLE_ODDS) & (sky_distance < _HOLE_DISTANCE)
    has_sky = np.flatnonzero(is_sky.mean(axis=1) >= _HORIZON_SHARE)
    is_hole[int(has_sky[-1]) + 1 if len(has_sky) else 0 :] = False
    is_ground = is_sky & _grown(~is_sky, _BORDER * longest)
    is_ground &= (odds < -_GROUND_ODDS) & (sky_distance > _GROUND_DISTANCE)
    return np.asarray((is_sky | is_hole) & ~is_ground)


def _fit(lab: Lab, region: Mask, kind: str, longest: int) -> tuple[Lab, Lab]:
    """Squared normalised distance of each pixel's colour from the region's around it, ``[H, W]``.

    Also the log of the product of the variances, ``[H, W]``.
    """
    sure = (~_grown(~region, _MARGIN[kind] * longest)).astype(np.float32)
    planes = np.dstack([sure, lab * sure[..., None], lab * lab * sure[..., None]])
    total = _blurred(planes, _REACH[kind] * longest)
    total += _FAR_WEIGHT * _blurred(planes, _FAR_REACH * longest)
    everywhere = planes.mean(axis=(0, 1), dtype=np.float64).astype(np.float32)
    total += _EVERYWHERE_WEIGHT * everywhere + 1e-12
    mean = total[..., 1:4] / total[..., :1]
    variance = np.maximum(total[..., 4:] / total[..., :1] - mean * mean, 0.0) + _FLOOR
    distance = ((lab - mean) ** 2 / variance).sum(axis=-1)
    return distance.astype(np.float32), np.log(variance).sum(axis=-1).astype(np.float32)


def _blurred(planes: Lab, sigma: float) -> Lab:
    """Gaussian blur, at a size where the standard deviation is about four pixels."""
    step = max(1, int(sigma / 4.0))
    height, width = planes.shape[:2]
    size = (max(1, width // step), max(1, height // step))
    result = np.empty_like(planes)
    for channel in range(planes.shape[2]):
        small = cv2.resize(planes[..., channel], size, interpolation=cv2.INTER_AREA)
        small = cv2.GaussianBlur(small, (0, 0), sigma / step)
        result[..., channel] = cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR)
    return result


def _grown(mask: Mask, reach_px: float) -> Mask:
    """The mask and everything within ``reach_px`` of it (a square)."""
    side = 2 * max(1, round(reach_px)) + 1
    return cv2.dilate(mask.astype(np.uint8), np.ones((side, side), np.uint8)).astype(np.bool_)


def _scaled(mask: Mask, size: tuple[int, int], interpolation: int) -> Mask:
    return np.asarray(cv2.resize(mask.astype(np.float32), size, interpolation=interpolation) >= 0.5)
