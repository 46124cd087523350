"""From the stored parameters of both sets to what the rasterizer draws, as one C++ kernel.

`r3gw.gaussians.reference` says in plain torch what it computes. Rows of the foreground come first.
"""

from dataclasses import dataclass, replace
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor
from torch.autograd.function import once_differentiable

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.
from r3gw.gaussians.model import SceneModel
from r3gw.gaussians.rows import OCCLUSION, Rows
from r3gw.geometry.cameras import Camera
from r3gw.shading.brdf_table import brdf_table

FOREGROUND_ROWS = (
    "means",
    "log_scales",
    "quaternions",
    "opacity_logits",
    "albedo_logits",
    "roughness_logits",
)
SKY_ROWS = ("angles", "log_scales", "quaternions", "opacity_logits")
COEFFICIENTS = (9, 25)  # SH degree 2 and 4: what the kernel is compiled for.


@dataclass(frozen=True)
class Splats:
    """Gaussians of both sets in one view; N counts the foreground's F first.

    Attributes:
        means: World positions.
        quaternions: Gaussian to world, wxyz, of any length.
        scales: Standard deviations, world units.
        opacities: In [0, 1].
        features: Channels of `r3gw.gaussians.compose`.
        depths: Camera z.
        smallest_scales: Of the foreground, world units.
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
    table = brdf_table() if model.settings.model.specular else None
    outputs = _Splats.apply(  # type: ignore[no-untyped-call]
        camera.cam_from_world,
        table,
        model.sky.centre,
        light.contiguous(),
        None if sky_light is None else sky_light.contiguous(),
        model.sky.radius,
        *(model.sky.rows[name] for name in SKY_ROWS),
        *(model.foreground[name] for name in FOREGROUND_ROWS),
        *shadows_of(model.foreground, light),
    )
    return Splats(*outputs)


def shadows_of(rows: Rows, light: Float[Tensor, "coeff 3"]) -> list[Float[Tensor, "f 3"]]:
    """What shadows change in the irradiance of each Gaussian; empty where none are modelled."""
    return [rows[OCCLUSION][:, : len(light)] @ light] if OCCLUSION in rows else []


class _Splats(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any,
        cam_from_world: Tensor,
        table: Tensor | None,
        centre: Tensor,
        light: Tensor,
        sky_light: Tensor | None,
        radius: Tensor,
        *rows: Tensor,
    ) -> tuple[Tensor, ...]:
        ctx.save_for_backward(centre, light, sky_light, radius, *rows)
        ctx.table, ctx.cam_from_world = table, cam_from_world
        foreground, sky = _inputs(rows, radius, centre)
        outputs = torch.ops.r3gw.splats(foreground, sky, light, table, sky_light, cam_from_world)
        return tuple(outputs)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, *gradients: Tensor) -> tuple[Tensor | None, ...]:
        centre, light, sky_light, radius, *rows = ctx.saved_tensors
        foreground, sky = _inputs(rows, radius, centre)
        results = torch.ops.r3gw.splats_backward(
            [gradient.contiguous() for gradient in gradients],
            *(foreground, sky, light, ctx.table, sky_light, ctx.cam_from_world),
        )
        to_foreground, to_rest = results[: len(foreground)], results[len(foreground) :]
        to_sky, (to_radius, to_light) = to_rest[: len(SKY_ROWS)], to_rest[len(SKY_ROWS) :][:2]
        to_sky_light = to_rest[-1] if sky_light is not None else None
        return (None, None, None, to_light, to_sky_light, to_radius, *to_sky, *to_foreground)


def _inputs(
    rows: "tuple[Tensor, ...] | list[Tensor]", radius: Tensor, centre: Tensor
) -> tuple[list[Tensor], list[Tensor]]:
    """The kernel's two lists: the foreground with its shadow; the sky, its radius, its centre."""
    split = len(SKY_ROWS)
    return list(rows[split:]), [*rows[:split], radius, centre]
