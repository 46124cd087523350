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
from r3gw.files import InputError
from r3gw.imaging.files import LDR_SUFFIXES, read_rgb
from r3gw.imaging.masks import read_mask


@dataclass(frozen=True)
class Scored:
    """One picture: the protocol's figures, the zero-filled ones, and how many pixels count."""

    name: str
    masked: Scores
    zero_filled: Scores
    num_pixels: int


def score_folders(renders: Path, truth: Path, masks: Path | None) -> list[Scored]:
    """Score every picture of ``renders`` against the photo of the same stem in ``truth``.

    Args:
        renders: Pictures (.png, .jpg, .jpeg).
        truth: Photos; may hold more than is scored.
        masks: Pictures, white = counts, one per render; resized and eroded as the protocol
            says. None counts whole pictures.

    Raises:
        InputError: If there is no render, or a photo or a mask is missing, of another size than
            its render, or empty.
    """
    pictures = pictures_by_stem(renders)
    photos = pictures_by_stem(truth)
    given = None if masks is None else pictures_by_stem(masks)
    return [
        _score_picture(path, _partner(photos, path, truth), given, masks)
        for path in tqdm(pictures.values(), desc="scoring", unit="picture", leave=False)
    ]


def pictures_by_stem(folder: Path) -> dict[str, Path]:
    """The pictures of a folder, in order of their names.

    Raises:
        InputError: If the folder holds none, or two of the same stem.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; name one that holds pictures")
    found: dict[str, Path] = {}
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() in LDR_SUFFIXES:
            if path.stem in found:
                raise InputError(
                    f"{folder}: holds both {found[path.stem].name} and {path.name}; keep one"
                )
            found[path.stem] = path
    if not found:
        raise InputError(f"{folder}: holds no picture ({', '.join(LDR_SUFFIXES)})")
    return found


def mean_scores(each: list[Scores]) -> Scores:
    """Mean of every metric over pictures."""
    return Scores(**{name: fmean(getattr(scores, name) for scores in each) for name in METRICS})


def pooled_scores(scored: list[Scored]) -> Scores:
    """All masked pixels of all pictures in one mean; the PSNR is that of the pooled MSE."""
    weights = [each.num_pixels for each in scored]

    def pooled(metric: str) -> float:
        return fmean((getattr(each.masked, metric) for each in scored), weights)

    return Scores(psnr_of_mse(pooled("mse")), pooled("ssim"), pooled("mse"), pooled("mae"))


def _score_picture(
    path: Path, photo_path: Path, masks: dict[str, Path] | None, folder: Path | None
) -> Scored:
    picture, photo = read_rgb(path) / 255.0, read_rgb(photo_path) / 255.0
    height, width = picture.shape[:2]
    if photo.shape != picture.shape:
        raise InputError(
            f"{path}: is {width}x{height} px, but {photo_path} is "
            f"{photo.shape[1]}x{photo.shape[0]} px; render at the photo's size"
        )
    is_scored = np.ones((height, width), np.bool_)
    if masks is not None and folder is not None:
        is_scored = evaluation_mask(read_mask(_partner(masks, path, folder)), width, height)
    masked = score(picture, photo, is_scored, path.stem)
    zero_filled = _zero_filled(picture, photo, is_scored, path.stem)
    return Scored(path.stem, masked, zero_filled, int(is_scored.sum()))


def _zero_filled(
    picture: Float[np.ndarray, "h w 3"],
    photo: Float[np.ndarray, "h w 3"],
    is_scored: Bool[np.ndarray, "h w"],
    name: str,
) -> Scores:
    kept = is_scored[..., None]
    return score(picture * kept, photo * kept, np.ones_like(is_scored), name)


def _partner(found: dict[str, Path], render: Path, folder: Path) -> Path:
    if render.stem not in found:
        raise InputError(f"{folder}: holds no picture named {render.stem}, as {render} needs")
    return found[render.stem]
