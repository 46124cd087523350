"""Training on smaller photos at first (beyond the paper).

Few Gaussians can only show coarse things, and a smaller photo shows those as well at a fraction of
the time. So photos grow with the number of Gaussians that may show them, an idea of Chen et al.,
"DashGaussian: Optimizing 3D Gaussian Splatting in 200 Seconds" (CVPR 2025), made here from the
paper. They let a size in proportion to what its frequencies contribute to the photos' spectrum
decide when a run moves on to the next; amplitudes of natural pictures fall as one over the
frequency (Field 1987), for which that rule makes the sides of the photos grow in proportion to the
iteration.
"""

from collections.abc import Sequence
from dataclasses import replace

import torch
from jaxtyping import Float, Int8
from torch import Tensor
from torch.nn.functional import interpolate

from r3gw.training.photos import Photo
from r3gw.training.schedule import Schedule

FEWEST_PX = 32  # No side is made smaller than this.


class PhotoSizes:
    """The training photos in the size that an iteration asks for, each kept in one at a time."""

    def __init__(self, photos: Sequence[Photo], schedule: Schedule) -> None:
        """Serve ``photos`` as ``schedule`` says."""
        self.photos = photos
        self.schedule = schedule
        self._kept: dict[int, tuple[float, Photo]] = {}

    def photo(self, index: int, iteration: int) -> Photo:
        """Photo ``index`` as iteration ``iteration`` (from 1) trains on it."""
        share = self.schedule.photo_share(iteration)
        whole = self.photos[index]
        if share >= 1.0:
            self._kept.clear()
            return whole
        kept = self._kept.get(index)
        if kept is None or kept[0] != share:
            kept = self._kept[index] = (share, smaller(whole, share))
        return kept[1]


def smaller(photo: Photo, share: float) -> Photo:
    """A photo with sides ``share`` times as long; its pixels average those that they cover.

    Occluders do not take part in the averages. A pixel is valid if at least half of what it covers
    is, and sky if at least half of what is valid there is. What was seen of the sky stays.
    """
    camera = photo.camera
    width, height = (
        max(round(share * side), min(side, FEWEST_PX)) for side in (camera.width, camera.height)
    )
    weight = photo.is_valid.float()
    valid = _averaged(weight[None], height, width)
    colours = _averaged(photo.planes.float() * weight, height, width) / valid.clamp_min(1e-6)
    sky = _averaged((photo.is_sky & photo.is_valid).float()[None], height, width)
    return replace(
        photo,
        camera=camera.scaled(width, height),
        planes=colours.round().clamp(0, 255).to(torch.uint8),
        is_valid=valid[0] >= 0.5,
        is_sky=sky[0] >= 0.5 * valid[0].clamp_min(1e-6),
        normals=None if photo.normals is None else _chosen(photo.normals, height, width),
    )


def _chosen(picture: Int8[Tensor, "h w 3"], height: int, width: int) -> Int8[Tensor, "h2 w2 3"]:
    """The pixels in the middle of the rectangles that fewer, larger pixels cover."""
    rows = (torch.arange(height) + 0.5) * picture.shape[0] / height
    columns = (torch.arange(width) + 0.5) * picture.shape[1] / width
    return picture[rows.long()][:, columns.long()]


def _averaged(
    planes: Float[Tensor, "c h w"], height: int, width: int
) -> Float[Tensor, "c {height} {width}"]:
    """Means over the rectangles of pixels that ``height`` x ``width`` larger pixels cover."""
    return interpolate(planes[None], (height, width), mode="area")[0]
