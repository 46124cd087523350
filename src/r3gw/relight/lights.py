"""Light over a film: an environment map, learned lights and blends of them, or the sun."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path
from typing import Literal

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.lighting import envmap
from r3gw.lighting.daylight import Sun, clear_day
from r3gw.lighting.maps import light_of_map, linear_env_map
from r3gw.lighting.sh_rotation import rotate
from r3gw.relight.picture import EnvMap, Illumination
from r3gw.relight.scene import Relightable
from r3gw.relight.sweep import Sweep

WHITE_SKY, LEARNED_SKY, MAP_SKY = "white", "learned", "map"
SUN_MAP_HEIGHT_PX = 64
STILL = Sweep((0.0,))


@dataclass(frozen=True)
class SunChoice:
    """A clear day; elevation and azimuth in degrees, turbidity 1 (clear) to 10 (hazy)."""

    elevation_deg: Sweep
    azimuth_deg: Sweep
    turbidity: float = 3.0


@dataclass(frozen=True)
class LightChoice:
    """Which light; exactly one of ``env_map``, ``photos`` and ``sun`` is given.

    Attributes:
        env_map: .exr or .hdr (linear), .png or .jpg (display values).
        photos: One training photo, or two whose learned lights are blended.
        sun: A sun position.
        blend: Share of the second photo, 0 to 1.
        yaw_deg: Turn of the light and of its sky about the vertical, from +z towards +x.
        exposure: Factor on the light and on its sky; ``auto`` makes its mean radiance that of
            the scene's learned lights; None is auto for the sun, else 1.
        sky: ``white``, ``map``, ``learned`` or ``learned:PHOTO``; None is the light's own.
    """

    env_map: Path | None = None
    photos: tuple[str, ...] = ()
    sun: SunChoice | None = None
    blend: Sweep = STILL
    yaw_deg: Sweep = STILL
    exposure: float | Literal["auto"] | None = None
    sky: str | None = None

    @property
    def moves(self) -> bool:
        """Whether frames have different lights."""
        sun = (self.sun.elevation_deg, self.sun.azimuth_deg) if self.sun else ()
        return any(sweep.moves for sweep in (self.blend, self.yaw_deg, *sun))


Lighting = Callable[[float], Illumination]


def lighting(splats: Relightable, choice: LightChoice, origin: Path) -> Lighting:
    """The illumination as a function of the share (0 to 1) of the film.

    Args:
        splats: The scene, with its learned lights.
        choice: What is wanted.
        origin: The scene's file, for messages.

    Raises:
        InputError: If not exactly one light is given, a photo or sky is unknown, a map
            unreadable, or a number out of range.
    """
    _refuse_contradictions(choice)
    if choice.env_map is not None:
        own = _map_lighting(linear_env_map(choice.env_map), splats.light_degree)
    elif choice.sun is not None:
        own = _sun_lighting(choice.sun, splats.light_degree)
    else:
        own = _learned_lighting(splats, choice, origin)
    seen = _sky(splats, choice, origin)
    exposure = _exposure(splats, choice, own, origin)

    def at(share: float) -> Illumination:
        yaw = radians(choice.yaw_deg.at(share))
        return _turned(seen(own(share)), yaw, exposure)

    return at


def _refuse_contradictions(choice: LightChoice) -> None:
    given = (choice.env_map is not None, bool(choice.photos), choice.sun is not None)
    if sum(given) != 1:
        raise InputError(
            "relighting needs exactly one light: give --env-map, or --light-of, or --sun"
        )
    if len(choice.photos) > 2:
        raise InputError(f"at most two learned lights can be blended, not {len(choice.photos)}")
    _within(choice.blend, 0.0, 1.0, "the share of a blend")
    if choice.blend != STILL and len(choice.photos) != 2:
        raise InputError("a blend needs two learned lights: give --light-of twice")
    if choice.sun is not None:
        _within(choice.sun.elevation_deg, 0.0, 90.0, "the sun's elevation in degrees")
        _within(Sweep((choice.sun.turbidity,)), 1.0, 10.0, "turbidity")


def _within(sweep: Sweep, low: float, high: float, what: str) -> None:
    for value in sweep.values:
        if not low <= value <= high:
            raise InputError(f"{what} must be {low:g} to {high:g}, not {value:g}")


def _map_lighting(env_map: Float[Tensor, "h w 3"], degree: int) -> Lighting:
    shown = Illumination(light_of_map(env_map, degree), env_map=EnvMap.of(env_map))
    return lambda _: shown


def _sun_lighting(choice: SunChoice, degree: int) -> Lighting:
    directions = envmap.pixel_directions(SUN_MAP_HEIGHT_PX, 2 * SUN_MAP_HEIGHT_PX)
    weights = envmap.projection_weights(directions, degree)

    def at(share: float) -> Illumination:
        sun = Sun(choice.azimuth_deg.at(share), choice.elevation_deg.at(share), choice.turbidity)
        day = torch.from_numpy(clear_day(sun, SUN_MAP_HEIGHT_PX)).float()
        return Illumination(envmap.projected(day, weights), env_map=EnvMap.of(day))

    if choice.azimuth_deg.moves or choice.elevation_deg.moves:
        return at
    still = at(0.0)
    return lambda _: still


def _learned_lighting(splats: Relightable, choice: LightChoice, origin: Path) -> Lighting:
    first = splats.light_of(choice.photos[0], origin)
    last = splats.light_of(choice.photos[-1], origin)

    def at(share: float) -> Illumination:
        weight = choice.blend.at(share)
        light, sky = (torch.lerp(a, b, weight) for a, b in zip(first, last, strict=True))
        return Illumination(light, sky_light=sky)

    return at


def _sky(
    splats: Relightable, choice: LightChoice, origin: Path
) -> Callable[[Illumination], Illumination]:
    """How an illumination's own sky is replaced by the one that was asked for."""
    name, _, photo = (choice.sky or "").partition(":")
    is_learned = bool(choice.photos)
    if choice.sky is None or (choice.sky == LEARNED_SKY and is_learned):
        return lambda shown: shown
    if choice.sky == WHITE_SKY:
        return lambda shown: Illumination(shown.light)
    if choice.sky == MAP_SKY:
        if is_learned:
            raise InputError("sky 'map' needs a map to show: light with --env-map or --sun")
        return lambda shown: shown
    if name == LEARNED_SKY and photo:
        sky_light = splats.light_of(photo, origin)[1]
        return lambda shown: Illumination(shown.light, sky_light=sky_light)
    if choice.sky == LEARNED_SKY:
        raise InputError("say whose sky: --sky learned:PHOTO, with a training photo's name")
    raise InputError(f"sky '{choice.sky}' is unknown; use white, map, learned or learned:PHOTO")


def _exposure(splats: Relightable, choice: LightChoice, own: Lighting, origin: Path) -> float:
    if isinstance(choice.exposure, float):
        return choice.exposure
    if choice.exposure is None and (choice.sun is None or not splats.lights):
        return 1.0
    if not splats.lights:
        raise InputError(f"{origin}: has no learned lights to set the exposure by; give a factor")
    learned = torch.stack([light[0].mean() for light, _ in splats.lights.values()])
    # A film keeps the exposure that suits its middle: dusk stays darker than noon.
    return float(learned.median() / own(0.5).light[0].mean().clamp_min(1e-6))


def _turned(shown: Illumination, yaw_rad: float, exposure: float) -> Illumination:
    """Turn light and sky about the vertical and multiply them."""
    light, sky_light, env_map = shown.light, shown.sky_light, shown.env_map
    if yaw_rad != 0:
        rotation = rotation_about_axis(1, yaw_rad)
        light = rotate(light, rotation)
        sky_light = None if sky_light is None else rotate(sky_light, rotation)
    if env_map is not None:
        env_map = replace(env_map, yaw_rad=yaw_rad, exposure=exposure)
    return Illumination(exposure * light, sky_light, exposure, env_map)
