"""What a sun adds to surfaces that see it: diffuse, and a GGX lobe in place of SH (Eq. 4, 5)."""

from math import pi, sqrt

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize

from r3gw.geometry.cameras import Camera
from r3gw.lighting.sun import PointSun
from r3gw.model.attributes import ALBEDO, ROUGHNESS
from r3gw.model.model import SceneModel
from r3gw.rendering.cook_torrance import DIELECTRIC_F0

SMALLEST_COSINE = 1e-3
# Half the sun's diameter in radians: no highlight is narrower, however smooth the surface.
SMALLEST_ALPHA = 0.005
DARKEST_ALBEDO = 1e-4
Y_00 = 1 / sqrt(4 * pi)


def sun_radiance(
    normals: Float[Tensor, "n 3"],
    to_camera: Float[Tensor, "n 3"],
    albedo: Float[Tensor, "n 3"],
    roughness: Float[Tensor, "n"],
    sun: PointSun,
    *,
    with_specular: bool,
) -> Float[Tensor, "n 3"]:
    """Linear radiance towards the camera of surfaces that nothing shades from the sun.

    Args:
        normals: Unit normals that face the camera.
        to_camera: Unit vectors from surface to camera.
        albedo: Linear, in [0, 1].
        roughness: Disney roughness in [0, 1].
        sun: The sun.
        with_specular: Whether surfaces reflect.
    """
    cosine = (normals @ sun.direction).clamp_min(0.0)
    reflectance = albedo / pi
    if with_specular:
        reflectance = reflectance + ggx(normals, to_camera, roughness, sun.direction)[:, None]
    return reflectance * cosine[:, None] * sun.irradiance


def ggx(
    normals: Float[Tensor, "n 3"],
    to_camera: Float[Tensor, "n 3"],
    roughness: Float[Tensor, "n"],
    to_light: Float[Tensor, "3"],
) -> Float[Tensor, "n"]:
    """The microfacet BRDF, per steradian, whose integral is `r3gw.rendering.brdf_table`.

    GGX with alpha = roughness**2, height-correlated Smith shadowing (Heitz 2014) and Schlick's
    Fresnel curve over `DIELECTRIC_F0`.
    """
    # Lengths and cosines of the half vector, between two unit vectors, from theirs.
    v_l, n_l, n_v = to_camera @ to_light, normals @ to_light, (normals * to_camera).sum(-1)
    shorter = torch.rsqrt((2 + 2 * v_l).clamp_min(SMALLEST_COSINE**2))
    n_h = ((n_l + n_v) * shorter).clamp(0.0, 1.0)
    v_h = ((1 + v_l) * shorter).clamp(0.0, 1.0)
    n_l, n_v = n_l.clamp_min(SMALLEST_COSINE), n_v.clamp_min(SMALLEST_COSINE)
    alpha2 = roughness.square().clamp_min(SMALLEST_ALPHA).square()
    distribution = alpha2 / (pi * (n_h.square() * (alpha2 - 1) + 1).square())
    towards_light = n_v * torch.sqrt(n_l.square() * (1 - alpha2) + alpha2)
    towards_camera = n_l * torch.sqrt(n_v.square() * (1 - alpha2) + alpha2)
    fresnel = DIELECTRIC_F0 + (1 - DIELECTRIC_F0) * (1 - v_h) ** 5
    return 0.5 * distribution * fresnel / (towards_light + towards_camera)


def direct_irradiance(
    model: SceneModel, normals: Float[Tensor, "f 3"], camera: Camera, sun: PointSun
) -> Float[Tensor, "f 3"]:
    """What the sun does to each foreground Gaussian of a model, as an irradiance.

    Shading multiplies it by albedo / pi, so the highlight is divided by that: its gradient to the
    albedo cancels.

    Args:
        model: The scene.
        normals: Of its foreground, turned to the camera.
        camera: Where from; directions of view carry no gradient.
        sun: The sun, which nothing shades.
    """
    foreground = model.foreground
    means = foreground["means"].detach()
    to_camera = normalize(camera.centre.to(means) - means, dim=-1)
    albedo = ALBEDO.of(foreground).clamp_min(DARKEST_ALBEDO)
    surfaces = (normals, to_camera, albedo, ROUGHNESS.of(foreground), sun)
    radiance = sun_radiance(*surfaces, with_specular=model.description.specular)
    return pi * radiance / albedo


def bounced_irradiance(
    occlusion: Float[Tensor, "f transfer"], sun: PointSun, share: float
) -> Float[Tensor, "f 3"]:
    """What surfaces get from others that stand in the sun.

    Args:
        occlusion: What shadows take from the irradiance, as SH transfer (`r3gw.model.occlusion`);
            its first coefficient says how much of the sky others hide.
        sun: The sun.
        share: Of the sun's irradiance, where others hide all of the sky.
    """
    hidden = -occlusion[:, :1] / (pi * Y_00)
    return share * hidden * sun.irradiance
