"""From the stored parameters of both sets to what the rasterizer draws, as one C++ kernel.

`r3gw.rendering.reference` says in plain torch what it computes. Rows of the foreground come first.
"""

from dataclasses import dataclass, replace

import torch
from jaxtyping import Float
from torch import Tensor

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.
from r3gw.geometry.cameras import Camera
from r3gw.model.attributes import FOREGROUND, SKY
from r3gw.model.model import SceneModel
from r3gw.model.rows import OCCLUSION, Rows
from r3gw.rendering.brdf_table import brdf_table

COEFFICIENTS = (9, 25)  # SH degree 2 and 4: what the kernel is compiled for.


@dataclass(frozen=True)
class Splats:
    """Gaussians of both sets in one view; N counts the foreground's F first.

    Attributes:
        means: World positions.
        quaternions: Gaussian to world, wxyz, of any length.
        scales: Standard deviations, world units.
        opacities: Opacities in [0, 1].
        features: Channels of `r3gw.rendering.compose`.
        depths: Camera z of the centres.
        smallest_scales: Smallest scale of each foreground Gaussian, world units.
    """

    means: Float[Tensor, "n 3"]
    quaternions: Float[Tensor, "n 4"]
    scales: Float[Tensor, "n 3"]
    opacities: Float[Tensor, "n"]
    features: Float[Tensor, "n 9"]
    depths: Float[Tensor, "n"]
    smallest_scales: Float[Tensor, "f"]

    def with_colours(self, colours: Float[Tensor, "n 3"]) -> "Splats":
        """The same Gaussians in other colours; the two channel sums stay as they are."""
        return replace(self, features=torch.cat([colours, self.features[:, 3:]], dim=-1))

    def with_channel_sums(self, sums: Float[Tensor, "n 2"]) -> "Splats":
        """The same Gaussians with other values in the two channel sums."""
        return replace(self, features=torch.cat([self.features[:, :7], sums], dim=-1))


def splats_of(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "4 3"] | None,
) -> Splats:
    """Activate, shade and colour all Gaussians of a model as a camera sees them.

    Gradients go to every parameter, to ``light`` and to ``sky_light``; directions of view carry
    none.

    Args:
        model: The scene.
        camera: Where from.
        light: SH environment light, linear; degree 2 or 4.
        sky_light: Sky coefficients (Eq. 11); None paints the sky white.

    Raises:
        ValueError: If ``light`` has neither 9 nor 25 coefficients.
    """
    if light.shape[0] not in COEFFICIENTS:
        raise ValueError(f"shading needs 9 or 25 light coefficients, got {light.shape[0]}")
    table = brdf_table() if model.description.specular else None
    foreground = [model.foreground[attribute.name] for attribute in FOREGROUND]
    sky = [model.sky.rows[attribute.name] for attribute in SKY]
    outputs = torch.ops.r3gw.splats(
        foreground + shadows_of(model.foreground, light),
        [*sky, model.sky.radius, model.sky.centre],
        light.contiguous(),
        table,
        None if sky_light is None else sky_light.contiguous(),
        camera.cam_from_world,
    )
    return Splats(*outputs)


def shadows_of(rows: Rows, light: Float[Tensor, "coeff 3"]) -> list[Float[Tensor, "f 3"]]:
    """What shadows change in the irradiance of each Gaussian; empty where none are modelled."""
    return [rows[OCCLUSION][:, : len(light)] @ light] if OCCLUSION in rows else []
