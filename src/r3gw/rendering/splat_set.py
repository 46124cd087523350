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


def irradiance_beside(
    rows: Rows, light: Float[Tensor, "coeff 3"], direct: Float[Tensor, "f 3"] | None
) -> Float[Tensor, "f 3"] | None:
    """Irradiance of each foreground Gaussian beside that of the unshaded light; None for none.

    Args:
        rows: The foreground.
        light: SH light, of which shadows take a part.
        direct: What comes from elsewhere; None for nothing.
    """
    if OCCLUSION not in rows:
        return direct
    shadow = rows[OCCLUSION][:, : len(light)] @ light
    return shadow if direct is None else shadow + direct
