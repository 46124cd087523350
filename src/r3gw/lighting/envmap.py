"""Environment maps: which direction a pixel shows, files, and projection on spherical harmonics.

A map is equirectangular, ``[H, 2H, 3]``, linear. The pixel at fractions (u, v) shows the
direction of polar angle ``pi v`` from up and azimuth ``2 pi (u - 0.5)`` (r3gw.geometry.spherical):
the map's centre looks along +z and its right half towards +x, as a panorama seen from inside.
"""

from functools import lru_cache
from math import pi
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.geometry.spherical import direction_from_angles
from r3gw.imaging.files import HDR_SUFFIXES, LDR_SUFFIXES, read_linear, read_rgb
from r3gw.lighting import sh


def pixel_angles(
    height: int, width: int
) -> tuple[Float[Tensor, "{height} {width}"], Float[Tensor, "{height} {width}"]]:
    """Polar angle and ``2 pi u`` of every pixel centre, in radians, float64."""
    v = (torch.arange(height, dtype=torch.float64) + 0.5) / height
    u = (torch.arange(width, dtype=torch.float64) + 0.5) / width
    theta, turn = torch.meshgrid(pi * v, 2 * pi * u, indexing="ij")
    return theta, turn


def pixel_directions(height: int, width: int) -> Float[Tensor, "{height} {width} 3"]:
    """World direction that each pixel centre shows, float64."""
    theta, turn = pixel_angles(height, width)
    return direction_from_angles(theta, turn - pi)


def published_directions(
    height: int, width: int, rotation_x_rad: float, sun_angle_rad: float
) -> Float[Tensor, "{height} {width} 3"]:
    """World direction of each pixel under the published NeRF-OSR protocol (mirrored).

    Args:
        height, width: Size of the map in pixels.
        rotation_x_rad: The published initial rotation about x, such as -pi/2.
        sun_angle_rad: Angle of the sweep.
    """
    theta, phi = pixel_angles(height, width)
    sine = torch.sin(theta)
    own = torch.stack([-sine * torch.cos(phi), -sine * torch.sin(phi), torch.cos(theta)], dim=-1)
    world_from_own = rotation_about_axis(1, -sun_angle_rad) @ rotation_about_axis(
        0, -rotation_x_rad
    )
    return own @ world_from_own.T


def project(
    env_map: Float[Tensor, "h w 3"], directions: Float[Tensor, "h w 3"], degree: int
) -> Float[Tensor, "coeff 3"]:
    """SH coefficients of a map whose pixels shine from ``directions``, float32."""
    return projected(env_map, projection_weights(directions, degree))


def projection_weights(
    directions: Float[Tensor, "h w 3"], degree: int
) -> Float[Tensor, "h w coeff"]:
    """Share of every pixel in every SH coefficient, float64; for many maps of one size.

    Pixels are weighted by their solid angle, and the weights are scaled to sum to 4 pi so that
    a constant map gives its exact constant at any resolution.
    """
    theta, _ = pixel_angles(*directions.shape[:2])
    weight = torch.sin(theta)
    weight = weight * (4 * pi / weight.sum())
    return sh.basis(directions.double(), degree) * weight[..., None]


@lru_cache(maxsize=2)
def own_weights(height: int, width: int, degree: int) -> Float[Tensor, "{height} {width} coeff"]:
    """`projection_weights` of maps that hang as this module says; the last two are kept."""
    return projection_weights(pixel_directions(height, width), degree)


def projected(
    env_map: Float[Tensor, "h w 3"], weights: Float[Tensor, "h w coeff"]
) -> Float[Tensor, "coeff 3"]:
    """SH coefficients of a map by its `projection_weights`, float32."""
    return torch.einsum("hwk,hwc->kc", weights, env_map.double()).float()


def draw(coefficients: Float[Tensor, "coeff 3"], height: int) -> Float[Tensor, "{height} w 3"]:
    """Evaluate SH light as a map of ``height`` x ``2 height`` pixels; may be negative."""
    directions = pixel_directions(height, 2 * height).float()
    return sh.radiance(coefficients, directions)


def require_env_map(path: Path) -> None:
    """Refuse what cannot be a map, by its name alone.

    Raises:
        InputError: If the file is missing or of another type.
    """
    if path.suffix.lower() not in (*HDR_SUFFIXES, *LDR_SUFFIXES):
        kinds = ", ".join((*HDR_SUFFIXES, *LDR_SUFFIXES))
        raise InputError(f"{path}: environment maps are {kinds} files")
    if not path.is_file():
        raise InputError(f"{path}: no such environment map; check the name and its folder")


def read_env_map(path: Path) -> Float[Tensor, "h w 3"]:
    """Read a map: linear values of .exr and .hdr as they are, 8-bit values / 255 unlinearised.

    Raises:
        InputError: If the file is missing, of another type, or not twice as wide as high.
    """
    require_env_map(path)
    is_linear = path.suffix.lower() in HDR_SUFFIXES
    image = read_linear(path) if is_linear else read_rgb(path).astype(np.float32) / 255.0
    height, width = image.shape[:2]
    if width != 2 * height:
        raise InputError(
            f"{path}: an environment map must be twice as wide as high (equirectangular), "
            f"but this one is {width}x{height} px"
        )
    return torch.from_numpy(np.ascontiguousarray(image))
