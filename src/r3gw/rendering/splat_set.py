"""What a rendering pass draws: the Gaussians of both sets in one view."""

from dataclasses import dataclass, replace

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.model.rows import OCCLUSION, Rows
from r3gw.rendering.channels import COLOUR, Layers


@dataclass(frozen=True)
class Splats:
    """Gaussians of both sets in one view; N counts the foreground's F first.

    Attributes:
        means: World positions.
        quaternions: Gaussian to world, wxyz, of any length.
        scales: Standard deviations, world units.
        opacities: Opacities in [0, 1].
        features: The columns of `r3gw.rendering.channels`.
        depths: Camera z of the centres.
        smallest_scales: Smallest scale of each foreground Gaussian, world units.
        layers: What the columns ``foreground`` and ``sky`` hold.
    """

    means: Float[Tensor, "n 3"]
    quaternions: Float[Tensor, "n 4"]
    scales: Float[Tensor, "n 3"]
    opacities: Float[Tensor, "n"]
    features: Float[Tensor, "n channels"]
    depths: Float[Tensor, "n"]
    smallest_scales: Float[Tensor, "f"]
    layers: Layers

    @property
    def colours(self) -> Float[Tensor, "n 3"]:
        """Display values of the Gaussians."""
        return self.features[:, COLOUR]

    def with_colours(self, colours: Float[Tensor, "n 3"]) -> "Splats":
        """The same Gaussians in other colours; all other channels stay as they are."""
        before, after = self.features[:, : COLOUR.start], self.features[:, COLOUR.stop :]
        return replace(self, features=torch.cat([before, colours, after], dim=-1))


def shadow_of(rows: Rows, light: Float[Tensor, "coeff 3"]) -> Float[Tensor, "f 3"] | None:
    """What shadows change in the irradiance of each foreground Gaussian; None without shadows."""
    return rows[OCCLUSION][:, : len(light)] @ light if OCCLUSION in rows else None
