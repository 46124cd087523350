"""The light in which a page opens, from the options of a picture (web/src/state.ts)."""

from math import log2
from typing import Any

from r3gw.files import InputError
from r3gw.relight.lights import LightOptions, PhotoSource, SunSource
from r3gw.relight.sweep import Sweep

SKIES = {None: "own", "white": "white", "map": "own", "learned": "own"}


def start_of(light: LightOptions, tone: str) -> dict[str, Any]:
    """What differs from the page's own beginning; readers may change all of it.

    Args:
        light: Stands still, and its photos are the scene's.
        tone: Name of the tone curve.

    Raises:
        InputError: If the light is a map, which is for the page's reader to drop.
    """
    kind, _, photo = (light.sky or "").partition(":")
    start = {
        **_source(light.source),
        "yaw": (light.yaw_deg.at(0.0) + 180) % 360 - 180,
        "tone": tone,
        "sky": "learned" if photo else SKIES[kind or None],
    }
    if photo and start["light"] == "sun":
        start["photo"] = photo
    is_sun = isinstance(light.source, SunSource)
    start["auto"] = light.exposure == "auto" or (light.exposure is None and is_sun)
    if isinstance(light.exposure, float):
        start["stops"] = log2(light.exposure)
    return start


def _source(source: Any) -> dict[str, Any]:
    if isinstance(source, PhotoSource):
        photo, *other = source.photos
        return {
            "light": "learned",
            "photo": photo,
            "photo2": other[0] if other else "",
            "blend": _still(source.blend),
        }
    if isinstance(source, SunSource):
        return {
            "light": "sun",
            "elevation": _still(source.elevation_deg),
            "azimuth": _still(source.azimuth_deg) % 360,
            "turbidity": source.turbidity,
        }
    raise InputError(
        "a page opens under a photo's light or the sun (its reader drops maps on it): give "
        "--light-of or --sun"
    )


def _still(sweep: Sweep) -> float:
    return sweep.at(0.0)
