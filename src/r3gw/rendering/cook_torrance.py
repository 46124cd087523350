"""Colour of foreground surfaces under SH light (paper, Sec. 4.2) in plain torch.

Pictures are shaded by csrc/shade.h (`r3gw.rendering.splats` and `r3gw.rendering.shading`), which is
held against this module; this is what they fall back to.
"""

from math import pi

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.lighting import sh
from r3gw.lighting.irradiance import irradiance
from r3gw.rendering.brdf_table import lookup

DIELECTRIC_F0 = 0.04
DARKEST_SPECULAR = 1e-4


def face_camera(
    normals: Float[Tensor, "n 3"], to_camera: Float[Tensor, "n 3"]
) -> Float[Tensor, "n 3"]:
    """Flip normals so that ``n . to_camera >= 0``."""
    away = (normals * to_camera).sum(-1, keepdim=True) < 0
    return torch.where(away, -normals, normals)


def diffuse(
    normals: Float[Tensor, "n 3"], albedo: Float[Tensor, "n 3"], light: Float[Tensor, "coeff 3"]
) -> Float[Tensor, "n 3"]:
    """Linear diffuse radiance ``albedo / pi * E(n)`` (Eq. 6)."""
    return albedo / pi * irradiance(light, normals)


def specular(
    normals: Float[Tensor, "n 3"],
    to_camera: Float[Tensor, "n 3"],
    roughness: Float[Tensor, "n"],
    light: Float[Tensor, "coeff 3"],
) -> Float[Tensor, "n 3"]:
    """Linear specular radiance by the split sum (Eq. 7-10).

    Args:
        normals: Unit normals that face the camera.
        to_camera: Unit vectors from surface to camera.
        roughness: Disney roughness in [0, 1].
        light: SH coefficients of the environment light.
    """
    cosine = (normals * to_camera).sum(-1)
    reflected = 2 * cosine[:, None] * normals - to_camera
    degree = int(light.shape[0] ** 0.5) - 1
    lobe = sh.basis(reflected, degree) * sh.smoothing_weights(roughness, degree)
    radiance = (lobe @ light).clamp_min(DARKEST_SPECULAR)
    f1, f2 = lookup(cosine, roughness)
    return radiance * (DIELECTRIC_F0 * f1 + f2)[:, None]


def shade(
    normals: Float[Tensor, "n 3"],
    to_camera: Float[Tensor, "n 3"],
    albedo: Float[Tensor, "n 3"],
    roughness: Float[Tensor, "n"],
    light: Float[Tensor, "coeff 3"],
    *,
    with_specular: bool,
) -> Float[Tensor, "n 3"]:
    """Linear radiance towards the camera: diffuse, plus specular if asked for (Eq. 4)."""
    colour = diffuse(normals, albedo, light)
    if with_specular:
        colour = colour + specular(normals, to_camera, roughness, light)
    return colour
