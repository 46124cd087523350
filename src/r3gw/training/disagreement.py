"""How unlike a rendering and a photo are, place by place, whatever the light."""

import cv2
import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

# Standard deviations, as shares of the longer side: of the window that structure is compared in,
# and of the smoothing of what comes out.
WINDOW, SMOOTHING = 0.008, 0.006
NOISE = 1e-3  # squared display values: structure fainter than that is none
CLEAR = 0.1  # display values: where colours differ by less, disagreement counts in proportion


def disagreement(
    rendered: Float[Tensor, "h w 3"], photo: Float[Tensor, "h w 3"], is_valid: Bool[Tensor, "h w"]
) -> Float[Tensor, "h w"]:
    """0 where pictures agree, about 1 where they have nothing in common, at most 2.

    It is one minus the structure term of SSIM (Wang et al. 2004), the mean over the channels,
    which does not mind a wrong exposure, white balance or soft shade; times the difference of
    colours up to `CLEAR`, since what looks the same does no harm. Both are smoothed.

    Args:
        rendered: Display values in [0, 1].
        photo: Display values in [0, 1].
        is_valid: Elsewhere the result is 0, and what the photo holds there does not matter.
    """
    valid = is_valid.numpy().astype(np.float32)
    ours, theirs = (picture.detach().float().numpy() for picture in (rendered, photo))
    theirs = np.where(valid[..., None] > 0, theirs, ours)
    longer = max(valid.shape)

    def mean(picture: np.ndarray) -> np.ndarray:
        return _blurred(picture, WINDOW * longer)

    mean_ours, mean_theirs = mean(ours), mean(theirs)
    covariance = mean(ours * theirs) - mean_ours * mean_theirs
    variances = mean(ours**2) - mean_ours**2 + mean(theirs**2) - mean_theirs**2
    structure = (2 * covariance + NOISE) / (variances + NOISE)
    unlike = _blurred((1 - structure).mean(axis=-1), SMOOTHING * longer)
    colours = _blurred(np.abs(ours - theirs).max(axis=-1), SMOOTHING * longer)
    return torch.from_numpy(unlike * np.minimum(colours / CLEAR, 1.0) * valid)


def _blurred(picture: np.ndarray, sigma: float) -> np.ndarray:
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), sigma))
