"""Who stands before the place in single photos, found while training (beyond the paper).

What a photo shows and the model does not may be detail that the model lacks, or somebody in the
way. Detail is lacking in all photos of a surface alike; a passer-by stands before it in one. So
every Gaussian gets the median, over the photos that see it, of how unlike rendering and photo are
there, and a photo is held against what its Gaussians look like elsewhere.

That what single photos of a place show beside its model should not be learned is Sabour et al.'s
("RobustNeRF", CVPR 2023, with a quantile of each photo's own errors), that it is found best before
there are Gaussians enough to show it Fu et al.'s ("RobustSplat", ICCV 2025).
"""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.model.model import SceneModel
from r3gw.rendering.compose import draw, shaded_splats, sunlight_of
from r3gw.rendering.sun_shadow import Gaussians
from r3gw.training.disagreement import disagreement
from r3gw.training.photos import Photo
from r3gw.training.resolution import smaller
from r3gw.training.settings import OccluderSettings

LONGER_SIDE_PX = 320  # of the photos that are compared
LEAST_SEEN_PX = 0.5  # pixels of a Gaussian that a photo must show to have a say
SMALLEST_ALPHA = 1e-3
FEWEST_PHOTOS = 3  # that must show a Gaussian before one of them can be wrong
MOST_UNLIKE = 2.0  # of `disagreement`
USUAL_FACTOR = 1.5  # a photo may be this much more unlike than others are before it counts
LEAST_EXPECTED = 0.01
# Of `contrast`: what is so unlike, and hangs together with what is unlike enough, is the same body,
# parts of which look like what they stand before (hysteresis, Canny 1986).
FAINT = 0.3
GROWN = 0.008  # of the longer side: the outlines of occluders are theirs, too


class Seen(NamedTuple):
    """One photo beside its rendering; means over Gaussians are NaN where it hardly shows them.

    Attributes:
        unlike: `disagreement`, by pixel.
        mean_unlike: Its mean over what the photo shows of each Gaussian.
    """

    unlike: Float[Tensor, "h w"]
    mean_unlike: Float[Tensor, "n"]


def find_occluders(
    model: SceneModel, photos: Sequence[Photo], settings: OccluderSettings
) -> list[Bool[Tensor, "h w"]]:
    """Where each photo shows what other photos of the same surfaces do not.

    What one or two photos see cannot be told from the place: it is no occluder.

    Args:
        model: The scene so far; it is not changed.
        photos: The training photos in the order of ``model.photos``, with the user's masks alone.
        settings: How different they must be, and how much of a photo may be.

    Returns:
        True on occluders, per photo in its own size.
    """
    small = [smaller(photo, min(1.0, LONGER_SIDE_PX / max(photo.is_sky.shape))) for photo in photos]
    was_training = model.appearance.training
    model.appearance.eval()
    seen = [_seen(model, index, photo) for index, photo in enumerate(small)]
    model.appearance.train(was_training)
    usual = _usual(torch.stack([each.mean_unlike for each in seen]))[:, None]
    gaussians = _gaussians(model, small[0])
    occluders = []
    for photo, compared, each in zip(photos, small, seen, strict=True):
        drawn = gaussians.drawn(usual, compared.camera)
        expected = drawn.planes[0] / drawn.alpha.clamp_min(SMALLEST_ALPHA)
        factor = USUAL_FACTOR * _badly_lit(each.unlike, expected, compared)
        excess = (each.unlike - factor * expected).numpy()
        mask = mask_of_excess(excess, settings, *photo.is_valid.shape)
        # Sky stands before nothing; where it differs, the model has something in its way.
        occluders.append(mask & photo.is_valid & ~photo.is_sky)
    return occluders


def _badly_lit(unlike: Float[Tensor, "h w"], expected: Float[Tensor, "h w"], photo: Photo) -> float:
    """How much more unlike all of a photo's foreground is than usual, at least 1.

    Hard light that the model does not have makes all of a photo differ; that is nobody's shape.
    """
    is_compared = photo.is_valid & ~photo.is_sky & (expected < 0.5 * MOST_UNLIKE)
    if not is_compared.any():
        return 1.0
    ratios = unlike[is_compared] / expected[is_compared].clamp_min(LEAST_EXPECTED)
    return max(1.0, float(ratios.median()))


def _usual(mean_unlike: Float[Tensor, "photos n"]) -> Float[Tensor, "n"]:
    """Of each Gaussian the median over photos; `MOST_UNLIKE` where these are too few."""
    is_shared = (~mean_unlike.isnan()).sum(dim=0) >= FEWEST_PHOTOS
    return torch.where(is_shared, mean_unlike.nanmedian(dim=0).values, MOST_UNLIKE)


def _seen(model: SceneModel, index: int, photo: Photo) -> Seen:
    """Render a photo and compare."""
    with torch.no_grad():
        lit = model.appearance(index)
        sunlight = sunlight_of(model, photo.camera, lit.sun)
        splats = shaded_splats(model, photo.camera, lit.light, lit.sky_light, sunlight=sunlight)
        colour = draw(splats, photo.camera).colour.clamp(0.0, 1.0)
    unlike = disagreement(colour, photo.target(), photo.is_valid)
    gaussians = Gaussians(splats.means, splats.quaternions, splats.scales, splats.opacities)
    # A Gaussian's share of a pixel is how the pixel changes with what the Gaussian holds.
    held = torch.zeros(len(splats.means), 2, requires_grad=True)
    planes = gaussians.drawn(held, photo.camera).planes
    sums = (planes * torch.stack([unlike, photo.is_valid.float()])).sum()
    total, weight = torch.autograd.grad(sums, held)[0].unbind(dim=-1)
    return Seen(unlike, torch.where(weight >= LEAST_SEEN_PX, total / weight, torch.nan))


@torch.no_grad()
def _gaussians(model: SceneModel, photo: Photo) -> Gaussians:
    """All Gaussians of a model, foreground first; any photo's light will do."""
    lit = model.appearance(0)
    splats = shaded_splats(model, photo.camera, lit.light, lit.sky_light)
    return Gaussians(splats.means, splats.quaternions, splats.scales, splats.opacities)


def mask_of_excess(
    excess: Float[np.ndarray, "a b"], settings: OccluderSettings, height: int, width: int
) -> Bool[Tensor, "{height} {width}"]:
    """What is unlike enough, with all around it that is somewhat unlike; bounded, and grown."""
    whole = cv2.resize(excess, (width, height), interpolation=cv2.INTER_LINEAR)
    least = float(np.quantile(whole, 1 - settings.most))
    faint = whole > max(FAINT * settings.contrast, least)
    regions = cv2.connectedComponents(faint.astype(np.uint8), connectivity=8)[1]
    is_found = np.isin(regions, np.unique(regions[whole > max(settings.contrast, least)]))
    radius = round(GROWN * max(height, width))
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    grown = cv2.dilate(is_found.astype(np.uint8), disk)
    return torch.from_numpy(grown > 0)
