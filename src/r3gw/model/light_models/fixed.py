"""Known light: every photo's SH coefficients are given, as true lights of made scenes are."""

from typing import Literal

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.lighting import sh
from r3gw.model.light_models.base import Environment, LightModel, LightModelDescription


class FixedLight(LightModel):
    """Lights that stay as they are; sky colours are learned as ever.

    Attributes:
        lights: ``[photos, coeff, 3]`` SH coefficients.
    """

    lights: Tensor

    def __init__(self, lights: Float[Tensor, "photos coeff 3"]) -> None:
        """Keep ``lights``, one per training photo."""
        # The MLP's own light, which nothing looks at, has the same layers as a free light's: so
        # runs with known and with learned lights draw the same first weights.
        super().__init__(torch.zeros_like(lights[0]))
        self.register_buffer("lights", lights)

    def describe(self) -> "FixedDescription":
        """As `LightModel.describe`."""
        return FixedDescription.model_validate({"degree": sh.degree_of(len(self.first))})

    def environment(
        self,
        photo: int,
        row: int,  # noqa: ARG002
        learned: Float[Tensor, "k 3"],  # noqa: ARG002
        exposure: Float[Tensor, ""] | None,  # noqa: ARG002
    ) -> Environment:
        """The photo's given light."""
        return Environment(self.lights[photo])


class FixedDescription(LightModelDescription):
    """A `FixedLight` of an SH degree."""

    kind: Literal["fixed"] = "fixed"

    def build(self, num_photos: int, num_rows: int) -> FixedLight:  # noqa: ARG002
        """As `LightModelDescription.build`."""
        return FixedLight(torch.zeros(num_photos, sh.num_coefficients(self.degree), 3))
