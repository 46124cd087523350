"""Free light: SH coefficients as the MLP gives them (paper, Eq. 3)."""

from typing import Literal

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.lighting import sh
from r3gw.model.light_models.base import Environment, LightModel, LightModelDescription


class FreeLight(LightModel):
    """Every coefficient of every photo is free."""

    def describe(self) -> "FreeDescription":
        """As `LightModel.describe`."""
        return FreeDescription.model_validate({"degree": sh.degree_of(len(self.first))})

    def environment(
        self,
        photo: int,  # noqa: ARG002
        row: int,  # noqa: ARG002
        learned: Float[Tensor, "k 3"],
        exposure: Float[Tensor, ""] | None,
    ) -> Environment:
        """The MLP's coefficients times the exposure."""
        return Environment(learned if exposure is None else learned * exposure)


class FreeDescription(LightModelDescription):
    """A `FreeLight` of an SH degree."""

    kind: Literal["free"] = "free"

    def build(self, num_photos: int, num_rows: int) -> FreeLight:  # noqa: ARG002
        """As `LightModelDescription.build`."""
        return FreeLight(torch.zeros(sh.num_coefficients(self.degree), 3))
