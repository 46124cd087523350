"""Clear days: an environment map of sun and sky for a sun position (Hosek and Wilkie 2012, 2013).

A map is linear RGB ``[H, 2H, 3]`` in this project's convention (r3gw.lighting.envmap). Sky and sun
are Mitsuba's `sunsky` model times `SKY_SCALE`; the lower half is a Lambertian ground lit by the
upper half. The sun's energy lies in the four pixels around its direction, so it is wider than the
real 0.53 degrees, with its irradiance kept. Mitsuba is imported by the first map.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import cos, pi, radians, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from r3gw.files.extras import optional_module
from r3gw.geometry.cameras import UP
from r3gw.lighting.envmap import pixel_directions

Map = NDArray[np.float64]

MAP_HEIGHT_PX = 64  # of a clear day's map, where nobody asks for another
VARIANT = "scalar_rgb"  # the one of Mitsuba's that needs no LLVM
SKY_SCALE = 10.0
GROUND_ALBEDO = np.array([0.24, 0.23, 0.2])
SUN_DIAMETER_DEG = 0.5358


@dataclass(frozen=True)
class Sun:
    """Where the sun stands, and the haze before it.

    Attributes:
        azimuth_deg: World azimuth; 0 is +z, 90 is +x.
        elevation_deg: Above the horizon, 0 to 90.
        turbidity: Haze, 1 to 10.
    """

    azimuth_deg: float
    elevation_deg: float
    turbidity: float

    @property
    def direction(self) -> NDArray[np.float64]:
        """Unit vector towards the sun, in world axes."""
        azimuth, elevation = radians(self.azimuth_deg), radians(self.elevation_deg)
        level = cos(elevation)
        return np.array([level * sin(azimuth), -sin(elevation), level * cos(azimuth)])


def solid_angles(height: int) -> Map:
    """Solid angle of each pixel ``[H, 2H, 1]`` of a map, in steradian."""
    edges = np.cos(np.linspace(0.0, pi, height + 1))
    rows = (edges[:-1] - edges[1:]) * pi / height
    return np.repeat(rows[:, None, None], 2 * height, axis=1)


def clear_day(sun: Sun, height: int) -> Map:
    """The whole map ``[H, 2H, 3]``: sky, sun and the ground that they light."""
    directions = pixel_directions(height, 2 * height).numpy()
    weight = solid_angles(height) * np.maximum(-directions[..., 1:2], 0)
    light = clear_sky(sun, height) + splat(sun_irradiance(sun), sun, height)
    ground = GROUND_ALBEDO / pi * (light * weight).sum((0, 1))
    return np.where(directions[..., 1:2] < 0, light, ground)


def clear_sky(sun: Sun, height: int) -> Map:
    """The sky without the sun's disc; the lower half is 0."""
    upper = pixel_directions(height, 2 * height).numpy()[: height // 2]
    values = _radiance(sun, upper.reshape(-1, 3), SKY_SCALE, 0.0).reshape(upper.shape)
    return np.concatenate([np.maximum(values, 0.0), np.zeros_like(values)])


def sun_irradiance(sun: Sun) -> NDArray[np.float64]:
    """Irradiance of the sun on a plane that faces it: its radiance over rings of the disc."""
    radius, rings = radians(SUN_DIAMETER_DEG / 2), 24
    towards = sun.direction
    level = np.cross(towards, UP)
    level /= np.linalg.norm(level)
    turns = (np.arange(rings) + 0.5) / rings * radius
    points = towards * np.cos(turns)[:, None] + level * np.sin(turns)[:, None]
    area = 2 * pi * np.sin(turns) * radius / rings
    irradiance = (_radiance(sun, points, 0.0, SKY_SCALE) * area[:, None]).sum(axis=0)
    clamped: NDArray[np.float64] = np.maximum(irradiance, 0.0)
    return clamped


def splat(irradiance: NDArray[np.float64], sun: Sun, height: int) -> Map:
    """The sun as the bilinear footprint of its direction: exact irradiance and exact place."""
    theta = pi / 2 - radians(sun.elevation_deg)
    turn = (radians(sun.azimuth_deg) / (2 * pi) + 0.5) % 1.0
    row, column = theta / pi * height - 0.5, turn * 2 * height - 0.5
    light = np.zeros((height, 2 * height, 3))
    for i, share_down in ((int(np.floor(row)), 1 - row % 1), (int(np.floor(row)) + 1, row % 1)):
        for j, share in (
            (int(np.floor(column)), 1 - column % 1),
            (int(np.floor(column)) + 1, column % 1),
        ):
            light[i, j % (2 * height)] += irradiance * share_down * share
    return light / solid_angles(height)


def _radiance(
    sun: Sun, directions: NDArray[np.float64], sky_scale: float, sun_scale: float
) -> NDArray[np.float64]:
    """Radiance ``[N, 3]`` of Mitsuba's `sunsky` from directions ``[N, 3]``."""
    with _mitsuba() as mi:
        emitter = mi.load_dict(
            {
                "type": "sunsky",
                "sun_direction": [float(x) for x in sun.direction],
                "turbidity": sun.turbidity,
                "albedo": {"type": "rgb", "value": [float(x) for x in GROUND_ALBEDO]},
                "sky_scale": sky_scale,
                "sun_scale": sun_scale,
                # Mitsuba's zenith (+z) turned to the world's up (-y).
                "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], 90),
            }
        )
        interaction = mi.SurfaceInteraction3f()
        values = np.empty_like(directions)
        for i, (x, y, z) in enumerate(-directions):
            interaction.wi = mi.Vector3f(float(x), float(y), float(z))
            values[i] = np.asarray(emitter.eval(interaction))
    return values


@contextmanager
def _mitsuba() -> Iterator[Any]:
    """Mitsuba in `VARIANT`; a variant that the caller's program has chosen is chosen again."""
    mitsuba = optional_module("mitsuba")
    before = mitsuba.variant()
    mitsuba.set_variant(VARIANT)
    try:
        yield mitsuba
    finally:
        mitsuba.set_variant(before or VARIANT)
