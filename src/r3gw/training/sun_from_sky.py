"""Where the sun stands, from how a clear sky is graded in photos that do not show the sun.

A clear sky is brighter towards the sun. Of directions all over the upper half that one is taken
whose CIE sky is most like that of the photos in the logarithm of its brightness, at any scale.
"""

from collections.abc import Sequence
from math import pi, sqrt

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.lighting.cie_sky import clear_sky
from r3gw.model.occlusion import upper_directions
from r3gw.training.visible_sky import VisibleSky

CANDIDATES = 1000  # directions, about 4 degrees apart
LOWEST_SINE = 0.08  # of the sun's height: nearer to the horizon, haze hides it
DARKEST = 1e-3  # radiance whose logarithm is taken
# A sky is clear if its grading explains the spread of brightness down to this share of it.
MOST_LEFT = 0.6


def sun_from_sky(photos: Sequence[VisibleSky]) -> Float[Tensor, "3"] | None:
    """Unit vector towards the sun; None if the sky is not like a clear one.

    Args:
        photos: What photos under the same sun show of their sky, at least one.
    """
    shown, looks = brightness_and_looks(photos)
    suns = upper_directions(CANDIDATES)
    suns = suns[-suns[:, 1] > LOWEST_SINE]
    left = torch.stack([spread(shown - clear_sky(looks, sun).sum(dim=0).log()) for sun in suns])
    best = int(left.argmin())
    return suns[best] if float(left[best]) < MOST_LEFT * float(spread(shown)) else None


def brightness_and_looks(
    photos: Sequence[VisibleSky],
) -> tuple[Float[Tensor, "n"], Float[Tensor, "n 3"]]:
    """Logarithm of the brightness of sky pixels, and the unit vectors in which they look."""
    brightness = torch.cat([photo.radiance.mean(dim=-1) for photo in photos])
    # Bands 1 of the basis are a factor times y, z and x.
    looks = torch.cat([photo.basis for photo in photos])[:, [3, 1, 2]] / sqrt(3 / (4 * pi))
    return brightness.clamp_min(DARKEST).log(), looks


def spread(values: Float[Tensor, "n"]) -> Float[Tensor, ""]:
    """Mean distance from the mean."""
    return (values - values.mean()).abs().mean()
