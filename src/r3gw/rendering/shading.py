"""Colours of a scene's foreground under a light that nothing is learned from.

What training renders is shaded by the kernel of `r3gw.rendering.splats`; this is the way for scenes
that are only shown: relit pictures, films, baked colours. Both run csrc/shade.h, the one production
form of the BRDF, whose plain form is `r3gw.rendering.cook_torrance`.
"""

from math import pi

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.native import kernels, ops
from r3gw.rendering import cook_torrance
from r3gw.rendering.brdf_table import brdf_table
from r3gw.rendering.splats import COEFFICIENTS


def shade(
    normals: Float[Tensor, "n 3"],
    to_camera: Float[Tensor, "n 3"],
    albedo: Float[Tensor, "n 3"],
    roughness: Float[Tensor, "n"],
    light: Float[Tensor, "coeff 3"],
    *,
    with_specular: bool,
) -> Float[Tensor, "n 3"]:
    """As `r3gw.rendering.cook_torrance.shade`, by a kernel where no gradient is asked for."""
    surfaces = (normals, to_camera, albedo, roughness, light)
    is_learned = torch.is_grad_enabled() and any(each.requires_grad for each in surfaces)
    if is_learned or len(light) not in COEFFICIENTS or not kernels.take("shade", *surfaces):
        return cook_torrance.shade(*surfaces, with_specular=with_specular)
    return ops.shade(*surfaces, brdf_table().to(light.device) if with_specular else None)


def shade_foreground(
    means: Float[Tensor, "n 3"],
    normals: Float[Tensor, "n 3"],
    albedo: Float[Tensor, "n 3"],
    roughness: Float[Tensor, "n"],
    camera_centre: Float[Tensor, "3"],
    light: Float[Tensor, "coeff 3"],
    *,
    with_specular: bool,
    occlusion: Float[Tensor, "n transfer"] | None = None,
) -> Float[Tensor, "n 3"]:
    """Linear radiance of foreground Gaussians towards a camera, shadows included.

    Args:
        means: World positions.
        normals: Unit normals; the sign is arbitrary, they are turned to the camera.
        albedo: Linear, in [0, 1].
        roughness: Disney roughness in [0, 1].
        camera_centre: Position of the camera in the world.
        light: SH coefficients of the environment light, linear.
        with_specular: Whether surfaces reflect.
        occlusion: What shadows take from the irradiance, as SH transfer of at least as many
            coefficients as the light has (`r3gw.model.occlusion`); None: no shadows.
    """
    to_camera = torch.nn.functional.normalize(camera_centre.to(means) - means, dim=-1)
    facing = cook_torrance.face_camera(normals, to_camera)
    linear = shade(facing, to_camera, albedo, roughness, light, with_specular=with_specular)
    if occlusion is None:
        return linear
    return linear + albedo / pi * (occlusion[:, : len(light)] @ light)
