"""Surfaces: albedo (flat or textured), roughness, gloss, and what the evaluation does with them.

Glossy surfaces are Mitsuba's `principled` model with dielectric reflectance F0 = 0.04 (`specular`
0.5); panes of glass have twice that, as a pane has two faces. Matte surfaces are Lambertian.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Any

import mitsuba as mi
import numpy as np

from r3gw.benchmark.textures import Image


class Kind(Enum):
    """What a surface belongs to; only buildings and paving are evaluated."""

    BUILDING = "building"
    GROUND = "ground"
    VEGETATION = "vegetation"
    BACKDROP = "backdrop"
    OCCLUDER = "occluder"


@dataclass(frozen=True)
class Material:
    """One surface.

    Attributes:
        albedo: Linear RGB, or a tileable texture ``[H, W, 3]`` with row 0 at v = 0.
        tile: Edge of the texture, in scene units.
        roughness: Disney roughness (GGX alpha is its square); None is Lambertian.
        specular: Mitsuba's `specular`; 0.5 is F0 = 0.04.
        kind: What it belongs to.
    """

    albedo: tuple[float, float, float] | Image
    tile: float = 1.0
    roughness: float | None = None
    specular: float = 0.5
    kind: Kind = Kind.BUILDING


def bsdf(material: Material) -> dict[str, Any]:
    """Mitsuba's description of a material, seen from both sides."""
    albedo: dict[str, Any]
    if isinstance(material.albedo, tuple):
        albedo = {"type": "rgb", "value": list(material.albedo)}
    else:
        albedo = {
            "type": "bitmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(material.albedo)),
            "raw": True,
            "wrap_mode": "repeat",
            "to_uv": mi.ScalarTransform3f().scale([1 / material.tile, 1 / material.tile]),
        }
    if material.roughness is None:
        inner: dict[str, Any] = {"type": "diffuse", "reflectance": albedo}
    else:
        inner = {
            "type": "principled",
            "base_color": albedo,
            "roughness": material.roughness,
            "specular": material.specular,
        }
    return {"type": "twosided", "bsdf": inner}
