"""Sessions of light and their environment maps: Hosek-Wilkie sun and sky, clouds, overcast.

A map is linear RGB ``[H, 2H, 3]`` in this project's convention (r3gw.lighting.envmap). Sky and sun
are those of r3gw.lighting.daylight; an overcast sky is the CIE standard overcast sky (CIE S 011)
mixed in; the lower half is a Lambertian ground lit by the upper half. The sun is about 1.4 degrees
wide instead of 0.53, with its irradiance kept.
"""

from dataclasses import dataclass
from math import pi, radians, sin

import cv2
import numpy as np
from numpy.typing import NDArray

from r3gw.benchmark.textures import noise
from r3gw.imaging.colour import display_array_from_linear
from r3gw.lighting.daylight import (
    GROUND_ALBEDO,
    Map,
    Sun,
    clear_sky,
    solid_angles,
    splat,
    sun_irradiance,
)
from r3gw.lighting.envmap import pixel_directions

HEIGHT_PX = 256
# A panorama's display values above this count as clipped, as in the published entries.
CLIPPED = 0.99
# Geometric mean of a panorama's linear values: under middle grey, to keep the sky unclipped.
PANORAMA_GREY = 0.1


@dataclass(frozen=True)
class Session:
    """The light of one visit.

    Attributes:
        name: Date and time as in NeRF-OSR, ``dd-mm_hh_mm``.
        sun_azimuth_deg: World azimuth; 0 is +z (behind the building), 90 is +x (right of it).
        sun_elevation_deg: Above the horizon.
        turbidity: Haze, 1 to 10.
        overcast: Share of a closed cloud cover, 0 to 1; it hides the sun and greys the sky.
        clouds: Cover of separate clouds, 0 to 1.
        is_test: Whether its photos are test views.
    """

    name: str
    sun_azimuth_deg: float
    sun_elevation_deg: float
    turbidity: float
    overcast: float
    clouds: float
    is_test: bool = False

    @property
    def sun_direction(self) -> NDArray[np.float64]:
        """Unit vector towards the sun, in world axes."""
        return self.sun.direction

    @property
    def sun(self) -> Sun:
        """The sun and its haze."""
        return Sun(self.sun_azimuth_deg, self.sun_elevation_deg, self.turbidity)


def environment(session: Session, random: np.random.Generator, height: int = HEIGHT_PX) -> Map:
    """Draw the linear map of a session, in relative radiance."""
    directions = pixel_directions(height, 2 * height).numpy()
    is_up = directions[..., 1] < 0
    sky = clear_sky(session.sun, height)
    sky *= is_up[..., None]
    weight = solid_angles(height) * np.maximum(-directions[..., 1:2], 0)
    sun = sun_irradiance(session.sun)
    level = (sky * weight).sum((0, 1)) + sun * sin(radians(session.sun_elevation_deg))
    sky = _with_clouds(sky, session, random, directions, level)
    closed = _overcast(directions, level, session.overcast)
    share = session.overcast
    light = (sky * (1 - share) + closed * share) * is_up[..., None]
    light = light + splat(sun * (1 - share) ** 2 * (1 - 0.25 * session.clouds), session.sun, height)
    ground = GROUND_ALBEDO / pi * (light * weight).sum((0, 1))
    return np.where(is_up[..., None], light, ground)


def _overcast(directions: Map, level: NDArray[np.float64], share: float) -> Map:
    """CIE standard overcast sky, (1 + 2 cos) / 3 of the zenith, dimmer the more it is closed."""
    dimmed = level.mean() * (0.75 - 0.5 * share) * np.array([0.97, 1.0, 1.05])
    zenith = dimmed * 9 / (7 * pi)  # The gradient's irradiance is 7 pi / 9 of its zenith
    height = np.maximum(-directions[..., 1:2], 0)
    return np.asarray(zenith * (1 + 2 * height) / 3)


def _with_clouds(
    sky: Map,
    session: Session,
    random: np.random.Generator,
    directions: Map,
    level: NDArray[np.float64],
) -> Map:
    """Separate clouds: noise on a layer above, bright towards the sun, thin towards the horizon."""
    field = noise(random, 1.55).astype(np.float32)
    streak = noise(random, 1.2, (1.0, 0.4)).astype(np.float32)
    height = np.maximum(-directions[..., 1], 0.02)
    scale = 34.0 / (height + 0.12)
    x = np.mod(directions[..., 0] * scale, field.shape[1]).astype(np.float32)
    y = np.mod(directions[..., 2] * scale, field.shape[0]).astype(np.float32)
    layer = np.pad(field + 0.35 * streak, ((0, 1), (0, 1)), mode="wrap")
    density = cv2.remap(layer, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    threshold = 1.6 - 2.6 * session.clouds
    cover = np.clip((density - threshold) / 1.1, 0, 1) ** 0.8
    cover = cover * min(1.0, 3.0 * session.clouds)
    cover = (cover * np.clip(height / 0.12, 0.25, 1))[..., None] * 0.85
    towards = np.clip(directions @ session.sun_direction, 0, 1)[..., None]
    shade = np.clip(1.15 - 0.28 * (density[..., None] - threshold), 0.55, 1.1)
    white = level / pi * (0.5 + 0.7 * towards**3) * shade
    return np.asarray(sky * (1 - cover) + white * cover)


def phone_panorama(light: Map, yaw_rad: float) -> NDArray[np.float32]:
    """What a 360 degree phone camera would save: display values, clipped sun with bloom, turned.

    Args:
        light: The session's linear map.
        yaw_rad: The phone's own heading: the picture's azimuth ``psi`` shows the world's azimuth
            ``psi + yaw``; the picture is turned by the nearest whole pixel (`whole_pixel_yaw`).
    """
    picture = display_array_from_linear(_captured(light))
    shift = round(yaw_rad / (2 * pi) * light.shape[1])
    return np.asarray(np.roll(picture, -shift, axis=1), dtype=np.float32)


def clipped_scale(light: Map) -> float:
    """Factor on a panorama's clipped values that gives back the light that clipping took.

    One number per session, at least 1: a grey sky has no sun to give back.

    Args:
        light: The session's linear map.
    """
    captured = _captured(light)
    weight = solid_angles(light.shape[0])
    lost = float((weight * (_exposed(light) - captured)).sum())
    clipped = float((weight * (display_array_from_linear(captured) > CLIPPED)).sum())
    return 1.0 + max(lost, 0.0) / clipped if clipped > 0 else 1.0


def _exposed(light: Map) -> Map:
    exposure = PANORAMA_GREY / np.exp(np.log(light.mean(axis=2) + 1e-6).mean())
    return np.asarray(light * exposure)


def _captured(light: Map) -> Map:
    """Linear values that reach the file: the sun clipped, its glare spilled around it."""
    exposed = _exposed(light)
    spill = np.minimum(exposed, 400.0) - np.minimum(exposed, 1.5)
    bloom = np.zeros_like(exposed)
    for sigma, share in ((1.2, 0.5), (5.0, 0.35), (16.0, 0.15)):
        padded = np.concatenate([spill[:, -64:], spill, spill[:, :64]], axis=1)
        bloom += share * cv2.GaussianBlur(padded, (0, 0), sigma)[:, 64:-64]
    return np.clip(np.minimum(exposed, 1.5) + bloom, 0.0, 1.0)


def whole_pixel_yaw(yaw_rad: float, height: int = HEIGHT_PX) -> float:
    """The yaw that `phone_panorama` really applies."""
    return round(yaw_rad / (2 * pi) * 2 * height) * pi / height


def published_sun_angle(session: Session, yaw_rad: float) -> float:
    """Sweep angle at which the published mirrored mapping puts the picture's sun right.

    The published mapping shows azimuth ``phi = 2 pi u`` of the picture at the world direction
    ``(-cos(phi + angle), ., -sin(phi + angle))`` (x and z), so ``phi + angle`` must be
    ``-pi/2 - azimuth`` of the true sun. The angle is given in [-pi, pi).

    Args:
        session: Gives the true sun.
        yaw_rad: The phone's heading that was applied.
    """
    azimuth = radians(session.sun_azimuth_deg)
    phi = azimuth - yaw_rad + pi  # psi = 2 pi (u - 0.5)
    angle = -pi / 2 - azimuth - phi
    return (angle + pi) % (2 * pi) - pi
