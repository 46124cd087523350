"""Sky Gaussians on a hemisphere with one shared, learnable radius (paper, Sec. 4.3).

Position: ``centre + R * d(theta, phi)`` in the angles of r3gw.geometry.spherical; theta in
[0, pi/2], phi in the azimuth range that the training cameras see.
"""

from dataclasses import dataclass
from math import log, pi

import torch
from jaxtyping import Float
from torch import Tensor, nn

from r3gw.geometry.spherical import angles_from_direction, direction_from_angles
from r3gw.imaging.colour import two_way_clamp
from r3gw.lighting import sh
from r3gw.model.attributes import ANGLES, OPACITY, SKY, first_rows
from r3gw.model.rows import Rows
from r3gw.model.settings import InitSettings

PREFIX = "sky."
SKY_DEGREE = 1
SMALLEST_RADIUS = 1e-3
GOLDEN_SECTION = (5**0.5 - 1) / 2


@dataclass(frozen=True)
class SkyDome:
    """Where the sky may be.

    Attributes:
        centre: ``[3]``, world.
        radius: Initial radius, world units.
        azimuth_rad: First and last phi; the first may lie below -pi.
    """

    centre: Float[Tensor, "3"]
    radius: float
    azimuth_rad: tuple[float, float]


def sample_dome(
    dome: SkyDome, count: int, generator: torch.Generator
) -> Float[Tensor, "{count} 2"]:
    """Angles (theta, phi) of ``count`` points uniform on the dome: height, then azimuth."""
    height, turn = torch.rand(2, count, generator=generator)
    first, last = dome.azimuth_rad
    return torch.stack([torch.acos(height), first + (last - first) * turn], dim=-1)


def even_dome(dome: SkyDome, count: int) -> Float[Tensor, "{count} 2"]:
    """Angles (theta, phi) of ``count`` points spaced evenly on the dome: a Fibonacci lattice.

    Heights are evenly spaced, since equal heights hold equal areas of a sphere, and azimuths turn
    by the golden section (González, 2010).
    """
    steps = torch.arange(count, dtype=torch.float64)
    first, last = dome.azimuth_rad
    turn = torch.remainder(steps * GOLDEN_SECTION, 1.0)
    angles = torch.stack([torch.acos((steps + 0.5) / count), first + (last - first) * turn], dim=-1)
    return angles.float()


class Sky(nn.Module):
    """The sky's Gaussians.

    ``rows`` holds angles (theta, phi), log_scales, quaternions and opacity_logits;
    ``radius`` (world units) is shared.
    """

    centre: Tensor
    azimuth_rad: Tensor

    def __init__(self, dome: SkyDome, rows: Rows) -> None:
        """Put the Gaussians of ``rows`` on the dome."""
        super().__init__()
        self.register_buffer("centre", dome.centre.clone().float())
        self.register_buffer("azimuth_rad", torch.tensor(dome.azimuth_rad))
        self.radius = nn.Parameter(torch.tensor(dome.radius))
        self.rows = rows

    def means(self) -> Float[Tensor, "n 3"]:
        """Positions in the world."""
        theta, phi = self.rows["angles"].unbind(-1)
        return self.centre + self.radius * direction_from_angles(theta, phi)

    def colours(
        self, sky_light: Float[Tensor, "4 3"], camera_centre: Float[Tensor, "3"]
    ) -> Float[Tensor, "n 3"]:
        """Display colours (Eq. 11): SH + 0.5, clamped to [0, 1], in the direction of the look.

        Without the upper bound training finds skies of huge colour and hardly any opacity.

        The direction runs from camera to Gaussian, so that "up" in the coefficients is up in
        the sky, as in the environment light.
        """
        looks = torch.nn.functional.normalize(self.means() - camera_centre.to(self.centre), dim=-1)
        return two_way_clamp(sh.radiance(sky_light, looks.detach()) + 0.5, 0.0, 1.0)

    @torch.no_grad()
    def clamp_to_dome(self) -> None:
        """Put angles and radius back into their ranges; called after every optimizer step."""
        self.radius.clamp_(min=SMALLEST_RADIUS)
        first, last = self.azimuth_rad.tolist()
        angles = self.rows["angles"]
        angles.clamp_(angles.new_tensor((0.0, first)), angles.new_tensor((pi / 2, last)))

    @torch.no_grad()
    def keep_opaque(self, least: float) -> None:
        """Raise opacities below ``least``; called after every optimizer step."""
        if least > 0:
            self.rows[OPACITY.name].clamp_(min=log(least / (1 - least)))

    @torch.no_grad()
    def angles_of(self, positions: Float[Tensor, "n 3"]) -> Float[Tensor, "n 2"]:
        """Project points on the hemisphere and return their angles, inside the dome's ranges."""
        theta, phi = angles_from_direction(positions - self.centre)
        first, last = (float(value) for value in self.azimuth_rad)
        # Azimuths are periodic: count from the middle of the range before clamping.
        middle = 0.5 * (first + last)
        phi = middle + torch.remainder(phi - middle + pi, 2 * pi) - pi
        return torch.stack([theta.clamp(0.0, pi / 2), phi.clamp(first, last)], dim=-1)


def initial_sky(dome: SkyDome, angles: Float[Tensor, "n 2"], init: InitSettings) -> Sky:
    """Gaussians at ``angles``; their spacing sets their scale, the settings the rest."""
    positions = direction_from_angles(angles[:, 0], angles[:, 1]) * dome.radius
    first = {ANGLES.name: angles.clone(), **first_rows(SKY, positions, init)}
    return Sky(dome, Rows(PREFIX, first))
