"""What a photo shows of the sky: how bright its light is in known directions (beyond the paper).

Photos of surfaces fix the product of light and albedo alone. The sky in the same photo is the light
itself, in the same units, so it says how bright, and so how dark the surfaces are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi, sqrt

import torch
from jaxtyping import Bool, Float, UInt8
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.imaging.colour import linear_from_display
from r3gw.lighting import sh
from r3gw.lighting.outdoor import SKY_DEGREE

MOST_PIXELS, FEWEST_PIXELS = 256, 200  # That are kept; that must show sky.
CLIPPED = 253  # Display values from here on are lower bounds.
# Red over blue of a clear and of a covered sky.
CLEAR_RATIO, COVERED_RATIO = 0.5, 0.8


@dataclass(frozen=True)
class VisibleSky:
    """Sky pixels of one photo.

    Attributes:
        heights: Sine of the angle above the horizon.
        basis: SH basis of the outdoor light's sky in the pixels' directions.
        radiance: Linear, in the photo's own units.
        is_clipped: True where the radiance is a lower bound.
    """

    heights: Float[Tensor, "k"]
    basis: Float[Tensor, "k 4"]
    radiance: Float[Tensor, "k 3"]
    is_clipped: Bool[Tensor, "k 3"]

    def without(self, gains: Float[Tensor, "3"]) -> "VisibleSky":
        """The sky as a camera of gains 1 would have shown it."""
        return replace(self, radiance=self.radiance / gains)


def visible_sky(
    camera: Camera, planes: UInt8[Tensor, "3 h w"], is_sky: Bool[Tensor, "h w"]
) -> VisibleSky | None:
    """Evenly chosen sky pixels of a photo; None if it shows hardly any.

    Args:
        camera: The photo's camera.
        planes: The photo's display values, 0 to 255.
        is_sky: True where sky is seen and no occluder stands before it.
    """
    rows, columns = is_sky.nonzero(as_tuple=True)
    if len(rows) < FEWEST_PIXELS:
        return None
    chosen = torch.linspace(0, len(rows) - 1, min(MOST_PIXELS, len(rows))).long()
    row, column = rows[chosen], columns[chosen]
    fx, fy, cx, cy = camera.intrinsics
    x, y = (column + 0.5 - cx) / fx, (row + 0.5 - cy) / fy
    rays = torch.stack([x, y, torch.ones_like(x)], dim=-1).double() @ camera.cam_from_world[:3, :3]
    values = planes[:, row, column].T
    directions = torch.nn.functional.normalize(rays, dim=-1).float()
    return VisibleSky(
        -directions[:, 1],
        sh.basis(directions, SKY_DEGREE),
        linear_from_display(values.float() / 255.0),
        values >= CLIPPED,
    )


def first_sky(seen: Sequence[VisibleSky], otherwise: float) -> Float[Tensor, "4 3"]:
    """A sky of degree 1 to start from: the colour seen, and brighter above if it is covered.

    A covered sky is brighter towards the zenith (Moon and Spencer 1942; 1.5 to 3 times the horizon
    in the CIE's standard skies, here 2), a clear one is taken as even. Grey tells covered from
    clear.

    Args:
        seen: What photos of the same sky show of it.
        otherwise: Radiance of an even sky where none is seen.
    """
    sky = sh.constant(otherwise, SKY_DEGREE)
    if not seen:
        return sky
    colour = torch.cat([photo.radiance for photo in seen]).median(dim=0).values
    heights = torch.cat([photo.heights for photo in seen])
    gradient = cover_of(colour)
    horizon = colour / float(1 + gradient * heights.mean())
    # horizon * (1 + gradient * height), and height is -y: bands 0 and 1 hold it exactly.
    sky[0] = horizon * sqrt(4 * pi)
    sky[1] = -gradient * horizon * sqrt(4 * pi / 3)
    return sky


def cover_of(colour: Float[Tensor, "3"]) -> float:
    """How covered a sky of a colour is, 0 to 1: grey tells covered from clear."""
    ratio = float(colour[0] / colour[2].clamp_min(1e-6))
    return min(max((ratio - CLEAR_RATIO) / (COVERED_RATIO - CLEAR_RATIO), 0.0), 1.0)


def without_gains(
    seen: Sequence[VisibleSky | None], gains: Float[Tensor, "photos 3"]
) -> list[VisibleSky | None]:
    """The skies of photos as cameras of gains 1 would have shown them.

    Args:
        seen: What each photo shows.
        gains: Exposure times white balance of each photo.
    """
    return [None if sky is None else sky.without(own) for sky, own in zip(seen, gains, strict=True)]


def seen_by_row(rows: Sequence[int], seen: Sequence[VisibleSky | None]) -> list[list[VisibleSky]]:
    """Per row of the appearance embedding, the skies that its photos show.

    Args:
        rows: Row of each photo in the appearance embedding.
        seen: What each photo shows; photos at the end may be missing.
    """
    found: list[list[VisibleSky]] = [[] for _ in range(max(rows) + 1)]
    for row, sky in zip(rows, seen, strict=False):
        if sky is not None:
            found[row].append(sky)
    return found
