"""A sun with sharp shadows, and the CIE's skies around it, for every session (beyond the paper)."""

from typing import Literal

import torch
from jaxtyping import Float
from pydantic import Field
from torch import Tensor, nn

from r3gw.geometry.cameras import UP
from r3gw.lighting import sh
from r3gw.lighting.cie_sky import PARTS, sh_of_skies
from r3gw.lighting.outdoor import SKY_DEGREE, ground_light, outdoor_light
from r3gw.lighting.sun import PointSun
from r3gw.model.light_models.base import (
    DaySky,
    Environment,
    LightDegree,
    LightModel,
    LightModelDescription,
)


class DaylightDescription(LightModelDescription):
    """A `Daylight`.

    Attributes:
        ground_reflectance: What the ground reflects of what it gets.
        sun_bounce: Of the sun's irradiance, what a surface gets from others that stand in the sun,
            where they hide all of the sky.
        sharp: Share of the sun whose shadows are sharp; the rest is shaded by its SH.
    """

    kind: Literal["daylight"] = "daylight"
    ground_reflectance: float = Field(ge=0, le=1)
    sun_bounce: float = Field(ge=0, le=1)
    sharp: float = Field(ge=0, le=1)

    def build(self, num_photos: int, num_rows: int) -> "Daylight":  # noqa: ARG002
        """As `LightModelDescription.build`."""
        constants = (self.ground_reflectance, self.sun_bounce, self.sharp)
        return Daylight(num_rows, 1.0, *constants, self.degree)


class Daylight(LightModel):
    """A sun of learned direction and power, ground, and a sky whose colours photos show.

    Surfaces are shaded with the sun itself, not with its SH.

    Attributes:
        sun_directions: ``[rows, 3]`` towards the sun, of any length.
        log_sun_powers: ``[rows, 3]`` logarithm of the irradiance that faces the sun.
        sky_colours: ``[rows, parts, 3]`` as `DaySky` has them, before exposure.
        sky_suns: ``[rows, 3]`` unit vectors to where the skies' suns stand; they follow the
            sun's directions now and then.
    """

    sky_colours: Tensor
    sky_suns: Tensor

    def __init__(
        self,
        num_rows: int,
        first_sun_power: float,
        ground_reflectance: float,
        sun_bounce: float,
        sharp: float,
        degree: LightDegree,
    ) -> None:
        """Start with a sun of ``first_sun_power`` overhead and a black sky."""
        super().__init__(torch.zeros(sh.num_coefficients(SKY_DEGREE), 3))
        self.ground_reflectance, self.sun_bounce = ground_reflectance, sun_bounce
        self.sharp, self.degree = sharp, degree
        overhead = torch.tensor(UP).repeat(num_rows, 1)
        self.sun_directions = nn.Parameter(overhead)
        self.log_sun_powers = nn.Parameter(torch.full((num_rows, 3), first_sun_power).log())
        self.register_buffer("sky_colours", torch.zeros(num_rows, len(PARTS), 3))
        self.register_buffer("sky_suns", overhead.clone())

    def describe(self) -> DaylightDescription:
        """As `LightModel.describe`."""
        return DaylightDescription(
            degree=self.degree,
            ground_reflectance=self.ground_reflectance,
            sun_bounce=self.sun_bounce,
            sharp=self.sharp,
        )

    def environment(
        self,
        photo: int,  # noqa: ARG002
        row: int,
        learned: Float[Tensor, "k 3"],
        exposure: Float[Tensor, ""] | None,
    ) -> Environment:
        """Light of sun, sky and ground; what the MLP gives is added to the sky."""
        factor = 1.0 if exposure is None else exposure
        sky = DaySky(self.sky_colours[row] * factor, self.sky_suns[row], learned * factor)
        direction = nn.functional.normalize(self.sun_directions[row], dim=0)
        power = self.log_sun_powers[row].exp() * factor
        shapes, level = sh_of_skies(sky.sun, self.degree)
        light = (
            outdoor_light(sky.change, direction, power, self.ground_reflectance, self.degree)
            + shapes.T @ sky.colours
            + ground_light(level @ sky.colours, self.ground_reflectance, self.degree)
        )
        return Environment(light, sky, PointSun(direction, power))
