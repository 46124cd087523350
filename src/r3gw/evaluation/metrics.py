"""Image metrics over a mask: MSE, MAE, PSNR and SSIM.

All of them average over the masked pixels alone. Multiplying by the mask and averaging over the
frame would raise the PSNR by 3 dB at half coverage.
"""

from dataclasses import dataclass, fields
from math import log10

import numpy as np
from jaxtyping import Bool, Float
from skimage.metrics import structural_similarity

from r3gw.files import InputError
from r3gw.imaging.masks import erode, resize_mask

PSNR_FLOOR = 1e-6  # added to the MSE, so that a perfect picture has 60 dB
SSIM_WINDOW_PX = 5
EROSION_PX = 5


@dataclass(frozen=True)
class Scores:
    """Metrics of one picture: PSNR in dB, the others in display units."""

    psnr: float
    ssim: float
    mse: float
    mae: float


METRICS = tuple(field.name for field in fields(Scores))


def psnr_of_mse(mse: float) -> float:
    """Peak signal-to-noise ratio in dB of pictures in [0, 1]: ``-10 log10(mse + 1e-6)``."""
    return -10.0 * log10(mse + PSNR_FLOOR)


def evaluation_mask(
    given: Bool[np.ndarray, "h w"], width: int, height: int
) -> Bool[np.ndarray, "{height} {width}"]:
    """Fit an evaluation mask to its photo and erode it by 5x5; True = counts."""
    return erode(resize_mask(given, width, height), EROSION_PX)


def score(
    picture: Float[np.ndarray, "h w 3"],
    photo: Float[np.ndarray, "h w 3"],
    is_scored: Bool[np.ndarray, "h w"] | None = None,
    name: str = "picture",
) -> Scores:
    """Compare a picture with its photo, both display values in [0, 1].

    Args:
        picture: The rendering.
        photo: What it should look like, of the same size.
        is_scored: Which pixels count; None counts all.
        name: The view, for the error message.

    Raises:
        InputError: If no pixel counts.
    """
    if is_scored is None:
        is_scored = np.ones(photo.shape[:2], np.bool_)
    _refuse_empty(is_scored, name)
    picture, photo = picture.astype(np.float64), photo.astype(np.float64)
    difference = (picture - photo)[is_scored]
    _, similarity = structural_similarity(  # type: ignore[no-untyped-call]
        picture, photo, win_size=SSIM_WINDOW_PX, data_range=1.0, channel_axis=-1, full=True
    )
    mse = float(np.mean(difference**2))
    return Scores(
        psnr_of_mse(mse),
        float(np.mean(similarity[is_scored])),
        mse,
        float(np.mean(np.abs(difference))),
    )


def masked_psnr(
    picture: Float[np.ndarray, "h w c"],
    photo: Float[np.ndarray, "h w c"],
    is_scored: Bool[np.ndarray, "h w"],
    name: str,
) -> float:
    """The PSNR of `score` alone, for any number of channels.

    Raises:
        InputError: If no pixel counts.
    """
    _refuse_empty(is_scored, name)
    difference = picture[is_scored].astype(np.float64) - photo[is_scored].astype(np.float64)
    return psnr_of_mse(float(np.mean(difference**2)))


def _refuse_empty(is_scored: Bool[np.ndarray, "h w"], name: str) -> None:
    if not is_scored.any():
        raise InputError(
            f"view '{name}': its evaluation mask leaves no pixel (it is eroded by "
            f"{EROSION_PX}x{EROSION_PX} px); give a mask with a larger white area"
        )
