"""A light on a scene, and the sky that is seen with it: the one type for both."""

from dataclasses import dataclass, replace
from math import radians
from pathlib import Path

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.lighting.maps import light_of_map, linear_env_map
from r3gw.lighting.sh import degree_of
from r3gw.lighting.sh_rotation import rotate
from r3gw.lighting.skies import LearnedSky, MapSky, Sky
from r3gw.lighting.sun import PointSun, sun_of_map

DEGREE = 4  # The paper's, of environment light.
DARKEST = 1e-6  # Least strength that an exposure is reckoned from.


@dataclass(frozen=True, eq=False)
class Light:
    """Distant light and its sky.

    Every method returns another light. Directions and turns are in world axes (up is -y); angles
    of azimuth and yaw go from +z towards +x.

    Attributes:
        sh: Spherical-harmonics coefficients of the linear radiance (r3gw.lighting.sh).
        sky: What is seen behind the scene; None is paper white under every tone curve.
        point: What of it comes from one direction, where that is known; the SH hold it, too.
    """

    sh: Float[Tensor, "coeff 3"]
    sky: Sky | None = None
    point: PointSun | None = None

    @staticmethod
    def from_map(path: str | Path, *, degree: int = DEGREE) -> "Light":
        """The light of an environment map's file, with the map as the sky.

        Args:
            path: Equirectangular, 2:1; .exr or .hdr (linear), .png or .jpg (display values).
            degree: SH degree of the light.

        Raises:
            InputError: If the map is unreadable or not 2:1.
        """
        return Light.from_pixels(linear_env_map(Path(path)), degree=degree)

    @staticmethod
    def from_pixels(pixels: Float[Tensor, "h w 3"], *, degree: int = DEGREE) -> "Light":
        """The light of a linear environment map (r3gw.lighting.envmap), with the map as the sky."""
        return Light(light_of_map(pixels, degree), MapSky(pixels), sun_of_map(pixels))

    @staticmethod
    def sun(
        elevation_deg: float, azimuth_deg: float, *, turbidity: float = 3.0, degree: int = DEGREE
    ) -> "Light":
        """A clear day's sun and sky (Hosek and Wilkie 2012, 2013, as Mitsuba has them).

        Args:
            elevation_deg: How high the sun stands above the horizon, 0 to 90.
            azimuth_deg: Where the sun stands, from +z towards +x.
            turbidity: Haze, 1 (clear) to 10.
            degree: SH degree of the light.

        Raises:
            InputError: If a number is out of range, or Mitsuba is not installed.
        """
        from r3gw.lighting.daylight import MAP_HEIGHT_PX, Sun, clear_day

        _within(elevation_deg, 0.0, 90.0, "the sun's elevation in degrees")
        _within(turbidity, 1.0, 10.0, "turbidity")
        day = clear_day(Sun(azimuth_deg, elevation_deg, turbidity), MAP_HEIGHT_PX)
        return Light.from_pixels(torch.from_numpy(day).float(), degree=degree)

    @property
    def sky_coefficients(self) -> Float[Tensor, "skycoeff 3"] | None:
        """The learned sky's coefficients, as training renders them; None for a white sky.

        Raises:
            ValueError: If the sky is no learned one, or has an exposure.
        """
        if self.sky is None:
            return None
        if not isinstance(self.sky, LearnedSky) or self.sky.exposure != 1.0:
            raise ValueError("only a sky as it was learned for a photo has coefficients")
        return self.sky.coefficients

    @property
    def sh_beside_point(self) -> Float[Tensor, "coeff 3"]:
        """The SH light without the part that comes from one direction."""
        if self.point is None:
            return self.sh
        return self.sh - self.point.sh(degree_of(len(self.sh)))

    @property
    def strength(self) -> float:
        """Mean over channels of the constant coefficient: proportional to the mean radiance."""
        return float(self.sh[0].mean())

    def turned(self, yaw_deg: float) -> "Light":
        """Light and sky turned about the vertical."""
        return self if yaw_deg == 0 else self.rotated(rotation_about_axis(1, radians(yaw_deg)))

    def rotated(self, rotation: Float[Tensor, "3 3"]) -> "Light":
        """Light and sky that shine from ``rotation @ d`` as these do from ``d``."""
        sky = None if self.sky is None else self.sky.rotated(rotation)
        point = None if self.point is None else self.point.rotated(rotation)
        return Light(rotate(self.sh, rotation), sky, point)

    def times(self, factor: float) -> "Light":
        """Light and sky multiplied: an exposure."""
        sky = None if self.sky is None else self.sky.times(factor)
        return Light(
            factor * self.sh, sky, None if self.point is None else self.point.times(factor)
        )

    def factor_to(self, strength: float) -> float:
        """The exposure that brings this light to a `strength`."""
        return strength / max(self.strength, DARKEST)

    def blended(self, other: "Light", weight: float) -> "Light":
        """A mixture of two learned lights and their skies; a sun of both walks across the sky.

        Args:
            other: The other light.
            weight: 0 is this light, 1 the other.

        Raises:
            InputError: If a sky is no learned one, or the weight is not in 0 to 1.
        """
        _within(weight, 0.0, 1.0, "the weight of a blend")
        if not isinstance(self.sky, LearnedSky) or not isinstance(other.sky, LearnedSky):
            raise InputError("only learned lights with their own skies can be blended")
        exposure = (1 - weight) * self.sky.exposure + weight * other.sky.exposure
        sky = torch.lerp(self.sky.coefficients, other.sky.coefficients, weight)
        mixed = LearnedSky(sky, exposure)
        if self.point is None or other.point is None:
            return Light(torch.lerp(self.sh, other.sh, weight), mixed)
        point = self.point.towards(other.point, weight)
        rest = torch.lerp(self.sh_beside_point, other.sh_beside_point, weight)
        return Light(rest + point.sh(degree_of(len(rest))), mixed, point)

    def with_sky(self, sky: Sky | None) -> "Light":
        """The same light before another sky; None is white."""
        return replace(self, sky=sky)


def _within(value: float, low: float, high: float, name: str) -> None:
    if not low <= value <= high:
        raise InputError(f"{name} must be {low:g} to {high:g}, not {value:g}")
