"""Learned sun and sky of every session (beyond the paper): few unknowns instead of free light."""

from typing import Literal

import torch
from jaxtyping import Float
from pydantic import Field
from torch import Tensor, nn

from r3gw.geometry.cameras import UP
from r3gw.lighting import sh
from r3gw.lighting.outdoor import SKY_DEGREE, outdoor_light
from r3gw.model.light_models.base import (
    Environment,
    LightDegree,
    LightModel,
    LightModelDescription,
    OpenSky,
)


class OutdoorDescription(LightModelDescription):
    """An `OutdoorLight` over a ground that reflects ``ground_reflectance`` of what it gets."""

    kind: Literal["outdoor"] = "outdoor"
    ground_reflectance: float = Field(ge=0, le=1)

    def build(self, num_photos: int, num_rows: int) -> "OutdoorLight":  # noqa: ARG002
        """As `LightModelDescription.build`."""
        skies = torch.zeros(num_rows, sh.num_coefficients(SKY_DEGREE), 3)
        return OutdoorLight(skies, 1.0, self.ground_reflectance, self.degree)


class OutdoorLight(LightModel):
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
        degree: LightDegree,
    ) -> None:
        """Start with a sun of ``first_sun_power`` overhead; the light has SH ``degree``."""
        super().__init__(torch.zeros_like(first_skies[0]))
        num_rows = len(first_skies)
        self.ground_reflectance, self.degree = ground_reflectance, degree
        self.register_buffer("first_skies", first_skies)
        self.sun_directions = nn.Parameter(torch.tensor(UP).repeat(num_rows, 1))
        power = torch.full((num_rows, 3), first_sun_power)
        self.log_sun_powers = nn.Parameter(power.log())

    def describe(self) -> OutdoorDescription:
        """As `LightModel.describe`."""
        return OutdoorDescription(degree=self.degree, ground_reflectance=self.ground_reflectance)

    def environment(
        self,
        photo: int,  # noqa: ARG002
        row: int,
        learned: Float[Tensor, "k 3"],
        exposure: Float[Tensor, ""] | None,
    ) -> Environment:
        """Light of sun, sky and ground; what the MLP gives is added to the first sky."""
        factor = 1.0 if exposure is None else exposure
        sky = OpenSky((self.first_skies[row] + learned) * factor, learned * factor)
        direction = nn.functional.normalize(self.sun_directions[row], dim=0)
        power = self.log_sun_powers[row].exp() * factor
        light = outdoor_light(sky.radiance, direction, power, self.ground_reflectance, self.degree)
        return Environment(light, sky)
