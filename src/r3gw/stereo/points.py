"""Many points of a scene from its training photos: the foreground that training starts from."""

import logging
from collections.abc import Sequence
from pathlib import Path

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from tqdm import tqdm

from r3gw.scene import Scene
from r3gw.scene.selection import evenly
from r3gw.stereo.agreement import SPACING_PX, confirmed, thinned
from r3gw.stereo.completion import completed
from r3gw.stereo.neighbours import neighbours
from r3gw.stereo.photos import StereoPhoto, lifted, read_stereo_photo
from r3gw.stereo.sweep import DepthMap, swept_depth

MOST_PHOTOS = 100  # evenly chosen: a sweep takes a second
GUESSED_EVERY_PX = 4
NEAR_FOUND_PX = 5  # no guess is needed so near
# Bounds on what training starts from; hundreds of photos show one place many times.
MOST_FOUND, MOST_GUESSED = 30_000, 20_000

_LOG = logging.getLogger(__name__)


def dense_points(
    scene: Scene, scene_folder: Path, masks_folder: Path, points: Float[Tensor, "n 3"]
) -> Float[Tensor, "m 3"]:
    """Points on surfaces that two training photos agree on, and guesses where none do.

    A guess continues the depths found around it: what one photo alone shows must lie somewhere,
    and next to what is known it does less harm to other views than before a lens. Photos without
    any marked sky get no guesses, which might fill a sky that nobody found.

    Args:
        scene: The imported scene; photos that are not trained on are not looked at.
        scene_folder: Where it lies.
        masks_folder: Its masks; neither sky nor occluders are matched.
        points: Sparse points, world. They bound the depths and choose the neighbours.

    Raises:
        InputError: If a photo or mask is missing or unreadable.
    """
    sparse = points.double()
    views = evenly(scene.split("train"), MOST_PHOTOS)
    photos = [read_stereo_photo(view, scene_folder, masks_folder, sparse) for view in views]
    maps = [_map(index, photos, sparse) for index in tqdm(range(len(photos)), desc="stereo")]
    found, guessed, sizes = [], [], []
    for index, (photo, depths) in enumerate(zip(photos, maps, strict=True)):
        if depths is None:
            continue
        is_confirmed = confirmed(index, photos, maps)
        if not is_confirmed.any():
            continue
        found.append(lifted(depths.depth, is_confirmed, photo.camera))
        sizes.append(depths.depth[is_confirmed] / photo.camera.intrinsics[0])
        if photo.has_sky:
            guessed.append(_guesses(photo, depths.depth, is_confirmed))
    if not found:
        _LOG.warning("no two photos agree on a depth: training starts from the sparse points alone")
        return points.new_zeros(0, 3)
    spacing = SPACING_PX * float(torch.cat(sizes).median())
    on_surfaces = _at_most(thinned(torch.cat(found), spacing), MOST_FOUND)
    between = _at_most(torch.cat([on_surfaces[:0], *guessed]), MOST_GUESSED)
    return torch.cat([on_surfaces, between]).to(points.dtype)


def _at_most(points: Float[Tensor, "n 3"], count: int) -> Float[Tensor, "m 3"]:
    """So many of the points, evenly chosen in their order."""
    return points[evenly(range(len(points)), count)]


def _map(
    index: int, photos: Sequence[StereoPhoto], points: Float[Tensor, "n 3"]
) -> DepthMap | None:
    """A photo's depths; None if no other photo shows the same."""
    others = neighbours(index, photos, points)
    return swept_depth(photos[index], [photos[other] for other in others]) if others else None


def _guesses(
    photo: StereoPhoto, depth: Float[Tensor, "h w"], is_confirmed: Bool[Tensor, "h w"]
) -> Float[Tensor, "k 3"]:
    """World positions of a grid of foreground pixels away from those whose depth is known."""
    inverse = completed(torch.where(is_confirmed, 1 / depth, 0.0), is_confirmed.float())
    is_asked = torch.zeros_like(is_confirmed)
    is_asked[::GUESSED_EVERY_PX, ::GUESSED_EVERY_PX] = True
    near = torch.nn.functional.max_pool2d(
        is_confirmed.float()[None], NEAR_FOUND_PX, stride=1, padding=NEAR_FOUND_PX // 2
    )[0]
    is_asked &= photo.is_matched & (near == 0)
    return lifted(1 / inverse, is_asked, photo.camera)
