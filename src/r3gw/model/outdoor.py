"""Learned sun and sky of every session (beyond the paper): few unknowns instead of free light."""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn

from r3gw.lighting.outdoor import UP, outdoor_light


class OpenSky(NamedTuple):
    """A photo's sky above the horizon.

    Attributes:
        radiance: SH coefficients, linear.
        change: Their part that is learned.
    """

    radiance: Float[Tensor, "4 3"]
    change: Float[Tensor, "4 3"]


class OutdoorLight(nn.Module):
    """A sky that starts from what photos show, a sun of learned direction and power.

    Attributes:
        first_skies: ``[rows, 4, 3]`` what each row starts from.
        sun_directions: ``[rows, 3]`` towards the sun, of any length.
        log_sun_powers: ``[rows, 3]`` logarithm of the irradiance that faces the sun.
    """

    first_skies: Tensor

    def __init__(
        self,
        first_skies: Float[Tensor, "rows 4 3"],
        first_sun_power: float,
        ground_reflectance: float,
        degree: int,
    ) -> None:
        """Start with a sun of ``first_sun_power`` overhead; the light has SH ``degree``."""
        super().__init__()
        num_rows = len(first_skies)
        self.ground_reflectance, self.degree = ground_reflectance, degree
        self.register_buffer("first_skies", first_skies)
        self.sun_directions = nn.Parameter(torch.tensor(UP).repeat(num_rows, 1))
        power = torch.full((num_rows, 3), first_sun_power)
        self.log_sun_powers = nn.Parameter(power.log())

    def forward(
        self, row: int, change: Float[Tensor, "4 3"], exposure: Float[Tensor, ""] | float
    ) -> tuple[Float[Tensor, "coeff 3"], OpenSky]:
        """Light of a photo, and its sky above the horizon.

        Args:
            row: Session.
            change: What is learned on top of the first sky.
            exposure: Factor on both.
        """
        sky = OpenSky((self.first_skies[row] + change) * exposure, change * exposure)
        direction = nn.functional.normalize(self.sun_directions[row], dim=0)
        power = self.log_sun_powers[row].exp() * exposure
        light = outdoor_light(sky.radiance, direction, power, self.ground_reflectance, self.degree)
        return light, sky
