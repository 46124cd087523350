"""What shows where no Gaussian covers a pixel: the sky, or the black on which training drew.

Training has nothing but black behind its Gaussians, so it leaves dark ground, shadows and leaves
partly uncovered: such holes must stay black, or a veil of sky lies over them. What no Gaussian
covers at all must be sky, or a camera that leaves the range of the photos sees black. The two are
told apart by what does cover a pixel, and by the photos (`r3gw.relight.witnesses`).

All weights are shares of a pixel: foreground and sky are the opacities that the two sets of
Gaussians contribute to it, and dark is how surely photos saw the uncovered rest as black.
"""

from jaxtyping import Float
from torch import Tensor

FAINT = 0.03  # Opacity up to which a pixel counts as hardly covered.
# Of what is no foreground: covered so far by the sky's Gaussians, a pixel is sky with gaps, and
# below, it is something dark before the sky.
GAPS_FROM, SKY_FROM = 0.3, 0.7
SMALLEST_SHARE = 1e-6

Plane = Float[Tensor, "h w 1"]


def own_sky_behind(foreground: Plane, sky: Plane, dark: Plane) -> Plane:
    """Weight of the sky behind the sky's Gaussians, where these show that very sky."""
    return _let_through(foreground, sky) * (1.0 - dark)


def other_sky_seen(foreground: Plane, sky: Plane, dark: Plane) -> Plane:
    """Weight of a sky that takes the place of the one whose Gaussians were learned.

    It shows through them and behind them. Gaps that a photo's own sky had, for its darker clouds
    above all, are none of this sky.
    """
    share = sky / (1.0 - foreground).clamp_min(SMALLEST_SHARE)
    step = ((share - GAPS_FROM) / (SKY_FROM - GAPS_FROM)).clamp(0.0, 1.0)
    is_sky = step * step * (3.0 - 2.0 * step)
    return sky + _let_through(foreground, sky) * (1.0 - dark * (1.0 - is_sky))


def _let_through(foreground: Plane, sky: Plane) -> Plane:
    """The uncovered rest, as far as what covers the pixel is sky or hardly there."""
    rest = (1.0 - foreground - sky).clamp_min(0.0)
    return rest * (sky + FAINT) / (foreground + sky + FAINT)
