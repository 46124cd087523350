"""Light over the time of a film: an environment map, learned lights and blends of them, or the sun.

Time runs from 0 at the first frame to 1 at the last; a picture is a film of one frame, at 0.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median_low
from typing import Literal

from r3gw.files import InputError
from r3gw.lighting.envmap import require_env_map
from r3gw.lighting.light import Light
from r3gw.relight.gaussians import Relightable
from r3gw.relight.sweep import Sweep

WHITE_SKY, LEARNED_SKY, MAP_SKY = "white", "learned", "map"
STILL = Sweep((0.0,))


@dataclass(frozen=True)
class MapSource:
    """An environment map's file: .exr or .hdr (linear), .png or .jpg (display values)."""

    path: Path
    moves = False


@dataclass(frozen=True)
class PhotoSource:
    """Light learned for a training photo, or a blend of two.

    Attributes:
        photos: Name of the photo, or of the two that are blended.
        blend: Weight of the second photo's light, 0 to 1.
    """

    photos: tuple[str, ...]
    blend: Sweep = STILL

    @property
    def moves(self) -> bool:
        """Whether the light changes over time."""
        return self.blend.moves


@dataclass(frozen=True)
class SunSource:
    """A clear day.

    Attributes:
        elevation_deg: How high the sun stands above the horizon, 0 to 90.
        azimuth_deg: Where the sun stands, from +z towards +x.
        turbidity: Haze, 1 (clear) to 10.
    """

    elevation_deg: Sweep
    azimuth_deg: Sweep
    turbidity: float = 3.0

    @property
    def moves(self) -> bool:
        """Whether the light changes over time."""
        return self.elevation_deg.moves or self.azimuth_deg.moves


@dataclass(frozen=True)
class LightOptions:
    """The light of a picture or a film.

    Attributes:
        source: Where the light comes from.
        yaw_deg: Turn of the light and of its sky about the vertical, from +z towards +x.
        exposure: Factor on the light and on its sky; ``auto`` makes its mean radiance that of
            the scene's learned lights; None is auto for the sun, else 1.
        sky: ``white``, ``map``, ``learned`` or ``learned:PHOTO``; None is the source's own.
    """

    source: MapSource | PhotoSource | SunSource
    yaw_deg: Sweep = STILL
    exposure: float | Literal["auto"] | None = None
    sky: str | None = None

    @property
    def moves(self) -> bool:
        """Whether the light changes over time."""
        return self.source.moves or self.yaw_deg.moves


LightOverTime = Callable[[float], Light]


def require_map(options: LightOptions) -> None:
    """Refuse a map that is not there, before anything slow begins.

    Raises:
        InputError: If so, or if its name is that of no map.
    """
    if isinstance(options.source, MapSource):
        require_env_map(options.source.path)


def light_over_time(gaussians: Relightable, options: LightOptions) -> LightOverTime:
    """The light as a function of the time of a film.

    Raises:
        InputError: If a photo or sky is unknown, a map unreadable, a number out of range, or a
            sky does not go with the light.
    """
    match options.source:
        case MapSource(path):
            still = Light.from_map(path, degree=gaussians.light_degree)
            own: LightOverTime = lambda _: still  # noqa: E731
        case PhotoSource():
            own = _learned(gaussians, options.source)
        case SunSource():
            own = _sun(options.source, gaussians.light_degree)
    with_sky = _sky(gaussians, options)
    exposure = _exposure(gaussians, options, own)
    return lambda time: with_sky(own(time)).turned(options.yaw_deg.at(time)).times(exposure)


def still_light(gaussians: Relightable, options: LightOptions) -> Light:
    """The light of a picture, or of anything else that has no time.

    Raises:
        InputError: If the light moves, and as `light_over_time`.
    """
    if options.moves:
        raise InputError("this has one light: give plain numbers, not FROM:TO")
    return light_over_time(gaussians, options)(0.0)


def _learned(gaussians: Relightable, source: PhotoSource) -> LightOverTime:
    if len(source.photos) not in (1, 2):
        raise InputError(f"one learned light, or a blend of two, not {len(source.photos)}")
    _within(source.blend, 0.0, 1.0, "the weight of a blend")
    if source.blend != STILL and len(source.photos) != 2:
        raise InputError("a blend needs the learned lights of two photos")
    first, last = (gaussians.light_of(source.photos[i]) for i in (0, -1))
    return lambda time: first.blended(last, source.blend.at(time))


def _sun(source: SunSource, degree: int) -> LightOverTime:
    _within(source.elevation_deg, 0.0, 90.0, "the sun's elevation in degrees")

    def at(time: float) -> Light:
        elevation_deg, azimuth_deg = source.elevation_deg.at(time), source.azimuth_deg.at(time)
        return Light.sun(elevation_deg, azimuth_deg, turbidity=source.turbidity, degree=degree)

    still = at(0.0)
    return at if source.moves else lambda _: still


def _within(sweep: Sweep, low: float, high: float, what: str) -> None:
    for value in sweep.values:
        if not low <= value <= high:
            raise InputError(f"{what} must be {low:g} to {high:g}, not {value:g}")


def _sky(gaussians: Relightable, options: LightOptions) -> Callable[[Light], Light]:
    """How a light gets the sky that was asked for."""
    name, _, photo = (options.sky or "").partition(":")
    is_learned = isinstance(options.source, PhotoSource)
    if options.sky is None or (options.sky == LEARNED_SKY and is_learned):
        return lambda light: light
    if options.sky == WHITE_SKY:
        return lambda light: light.with_sky(None)
    if options.sky == MAP_SKY:
        if is_learned:
            raise InputError("sky 'map' needs the light of an environment map or of the sun")
        return lambda light: light
    if name == LEARNED_SKY and photo:
        sky = gaussians.light_of(photo).sky
        return lambda light: light.with_sky(sky)
    if options.sky == LEARNED_SKY:
        raise InputError("say whose sky: learned:PHOTO, with a training photo's name")
    raise InputError(f"sky '{options.sky}' is unknown; use white, map, learned or learned:PHOTO")


def _exposure(gaussians: Relightable, options: LightOptions, own: LightOverTime) -> float:
    if isinstance(options.exposure, float):
        return options.exposure
    is_sun = isinstance(options.source, SunSource)
    if options.exposure is None and not (is_sun and gaussians.lights):
        return 1.0
    # A film keeps the exposure that suits its middle: dusk stays darker than noon.
    return own(0.5).factor_to(learned_strength(gaussians))


def learned_strength(gaussians: Relightable) -> float:
    """Median of the learned lights' strengths (`Light.strength`).

    Raises:
        InputError: If the scene has no learned lights.
    """
    if not gaussians.lights:
        raise InputError(
            f"{gaussians.origin}: has no learned lights to set the exposure by; give a factor"
        )
    return median_low([light.strength for light in gaussians.lights.values()])
