"""A sun: a light from one direction, beside what SH hold of it (beyond the paper).

SH of degree 4 spread a sun over tens of degrees, so that it casts no sharp shadow. Where a
`PointSun` is known, a light's SH still hold all of it; who shades with the sun itself takes it off
them.
"""

from dataclasses import dataclass
from math import cos, pi, radians

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.lighting import envmap
from r3gw.lighting.outdoor import basis_of_one

# Around a map's brightest pixel. In a linear map the sun is far smaller, and so wide a circle adds
# no more than 3 % to its energy; where a phone's picture is clipped, its glare is as wide.
SUN_RADIUS_DEG = 15.0
RING_RADIUS_DEG = 20.0  # the sky around it, which is no sun
# A sun lights a plane that faces it with at least this share of what the whole upper sky gives a
# level one; less is a bright cloud.
LEAST_SHARE = 0.05
SAME_RAD = 1e-3  # between two directions that count as one


@dataclass(frozen=True, eq=False)
class PointSun:
    """Light from one direction.

    Attributes:
        direction: Unit vector towards the sun, in world axes.
        irradiance: What the sun gives a surface that faces it, linear.
    """

    direction: Float[Tensor, "3"]
    irradiance: Float[Tensor, "3"]

    def sh(self, degree: int) -> Float[Tensor, "coeff 3"]:
        """The SH light that holds as much of it as a degree can."""
        return basis_of_one(self.direction, degree)[:, None] * self.irradiance

    def rotated(self, rotation: Float[Tensor, "3 3"]) -> "PointSun":
        """The sun that stands at ``rotation @ direction``."""
        return PointSun((rotation.double() @ self.direction.double()).float(), self.irradiance)

    def times(self, factor: float | Float[Tensor, "3"]) -> "PointSun":
        """The sun multiplied, all channels alike or each by its own factor."""
        return PointSun(self.direction, self.irradiance * factor)

    def towards(self, other: "PointSun", weight: float) -> "PointSun":
        """A sun on its way to where another stands: 0 is this one, 1 the other.

        Args:
            other: The other sun; not exactly opposite, which leaves the way open.
            weight: 0 to 1.
        """
        cosine = (self.direction * other.direction).sum().clamp(-1.0, 1.0)
        angle = torch.arccos(cosine)
        if float(angle) < SAME_RAD:
            direction = self.direction
        else:
            first = torch.sin((1 - weight) * angle) * self.direction
            direction = (first + torch.sin(weight * angle) * other.direction) / torch.sin(angle)
        return PointSun(direction, torch.lerp(self.irradiance, other.irradiance, weight))


def sun_of_map(
    pixels: Float[Tensor, "h w 3"], directions: Float[Tensor, "h w 3"] | None = None
) -> PointSun | None:
    """The sun of a linear environment map; None where the sky has none.

    What the pixels around the brightest one are brighter than the sky beside them is the sun's: its
    energy is exact, its direction their centroid.

    Args:
        pixels: Equirectangular (r3gw.lighting.envmap), finite.
        directions: What each pixel shows; by default as `envmap.pixel_directions` says.
    """
    height, width = pixels.shape[:2]
    looks = envmap.pixel_directions(height, width) if directions is None else directions.double()
    values, is_up = pixels.double(), looks[..., 1] < 0
    solid_angle = torch.sin(envmap.pixel_angles(height, width)[0])
    solid_angle = solid_angle * (4 * pi / solid_angle.sum())
    brightness = torch.where(is_up, values.mean(-1), -1.0)
    cosine = looks @ looks.reshape(-1, 3)[int(brightness.argmax())]
    is_near = cosine > cos(radians(SUN_RADIUS_DEG))
    is_ring = is_up & ~is_near & (cosine > cos(radians(RING_RADIUS_DEG)))
    if not is_ring.any():
        return None
    beside = values[is_ring].median(dim=0).values
    excess = (values - beside).clamp_min(0.0) * (is_near * solid_angle)[..., None]
    irradiance = excess.sum((0, 1))
    level = (values * (is_up * solid_angle * -looks[..., 1])[..., None]).sum((0, 1))
    if not float(irradiance.mean()) > LEAST_SHARE * float(level.mean()):
        return None
    centroid = (excess.mean(-1, keepdim=True) * looks).sum((0, 1))
    direction = torch.nn.functional.normalize(centroid, dim=0)
    return PointSun(direction.float(), irradiance.float())
