"""Scores of any method's pictures, by the code that scores this project's own.

`masked` is the protocol: metrics over the masked pixels of each picture, then the mean over
pictures. Papers also print two other figures, which are not comparable with it, so they stand
beside it under their own names: `zero-filled` (outside the mask both pictures are black, and the
average runs over the whole frame, which raises the PSNR: 3 dB at half coverage) and `pooled` (all
masked pixels of all pictures in one mean, so that large masks weigh more).
"""

from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

import numpy as np
from jaxtyping import Bool, Float
from tqdm import tqdm

from r3gw.evaluation.metrics import METRICS, Scores, evaluation_mask, psnr_of_mse, score
from r3gw.evaluation.rendered import Picture, find_rendered, paired, pictures_by_name
from r3gw.files import InputError
from r3gw.imaging.masks import read_mask


@dataclass(frozen=True)
class Scored:
    """One picture: the protocol's figures, the zero-filled ones, and how many pixels count."""

    name: str
    masked: Scores
    zero_filled: Scores
    num_pixels: int


def score_folders(renders: Path, truth: Path | None, masks: Path | None) -> list[Scored]:
    """Score every picture of ``renders`` against its photo.

    Args:
        renders: Pictures, or a program's output that holds them (`r3gw.evaluation.rendered`).
        truth: Photos, which may be more than are scored. None takes those that the program wrote.
        masks: Pictures, white = counts, one per render; resized and eroded as the protocol
            says. None counts whole pictures.

    Raises:
        InputError: If there is no render, or a photo or a mask is missing, of another size than
            its render, or empty.
    """
    found = find_rendered(renders)
    photos, photos_folder = found.photos, renders
    if truth is not None:
        photos, photos_folder = pictures_by_name(truth), truth
    if photos is None:
        raise InputError(
            f"{renders}: holds no photos beside the renders; name their folder by --truth"
        )
    photos = paired(found.renders, photos, photos_folder, "photo")
    given = {}
    if masks is not None:
        given = paired(found.renders, pictures_by_name(masks), masks, "mask")
    return [
        _score_picture(name, picture, photos[name], given.get(name))
        for name, picture in tqdm(
            found.renders.items(), desc="scoring", unit="picture", leave=False
        )
    ]


def mean_scores(each: list[Scores]) -> Scores:
    """Mean of every metric over pictures."""
    return Scores(**{name: fmean(getattr(scores, name) for scores in each) for name in METRICS})


def pooled_scores(scored: list[Scored]) -> Scores:
    """All masked pixels of all pictures in one mean; the PSNR is that of the pooled MSE."""
    weights = [each.num_pixels for each in scored]

    def pooled(metric: str) -> float:
        return fmean((getattr(each.masked, metric) for each in scored), weights)

    return Scores(psnr_of_mse(pooled("mse")), pooled("ssim"), pooled("mse"), pooled("mae"))


def _score_picture(name: str, render: Picture, photo: Picture, mask: Picture | None) -> Scored:
    picture, target = render.read() / 255.0, photo.read() / 255.0
    height, width = picture.shape[:2]
    if target.shape != picture.shape:
        raise InputError(
            f"{render.path}: is {width}x{height} px, but {photo.path} is "
            f"{target.shape[1]}x{target.shape[0]} px; render at the photo's size"
        )
    is_scored = np.ones((height, width), np.bool_)
    if mask is not None:
        is_scored = evaluation_mask(read_mask(mask.path), width, height)
    masked = score(picture, target, is_scored, name)
    zero_filled = _zero_filled(picture, target, is_scored, name)
    return Scored(name, masked, zero_filled, int(is_scored.sum()))


def _zero_filled(
    picture: Float[np.ndarray, "h w 3"],
    photo: Float[np.ndarray, "h w 3"],
    is_scored: Bool[np.ndarray, "h w"],
    name: str,
) -> Scores:
    kept = is_scored[..., None]
    return score(picture * kept, photo * kept, np.ones_like(is_scored), name)
