"""``lights.json``: the learned lights of a scene, for r3gw and for anybody else."""

from collections.abc import Mapping
from math import isqrt
from pathlib import Path
from typing import Any, Literal

import torch
from jaxtyping import Float
from pydantic import field_validator
from torch import Tensor

from r3gw.files import write_json
from r3gw.files.strict import Strict, read_json, validated
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.lighting.sun import PointSun

NAME = "lights.json"
HIGHEST_DEGREE = 10
CONVENTION = {
    "basis": "real spherical harmonics, orthonormal, no Condon-Shortley phase; coefficient "
    "l*l + l + m for m = -l..l; degree 1 is 0.488603 times y, z, x",
    "axes": "right-handed; the directions are those of the coordinates of the PLY file beside this "
    "one. In scene coordinates up is -y",
    "light": "linear RGB radiance towards direction d = sum of coefficient[i] * Y_i(d)",
    "sky": "display RGB of the sky in direction d = clamp(sum of coefficient[i] * Y_i(d) + 0.5, "
    "0, 1); display = linear^(1/2.2)",
}
SUN_CONVENTION = {
    "sun": "the part of the light that comes from one direction: unit vector towards it, and "
    "linear RGB irradiance of a surface that faces it; the light's coefficients hold it, too",
}

Row = tuple[float, float, float]


class SunEntry(Strict):
    """The part of a light that comes from one direction, see `CONVENTION`."""

    direction: Row
    irradiance: Row


class Coefficients(Strict):
    """Light and sky of one photo, ``[coeff][rgb]``, and its sun, if it has one."""

    light: tuple[Row, ...]
    sky: tuple[Row, ...]
    sun: SunEntry | None = None

    @field_validator("light", "sky")
    @classmethod
    def _is_complete(cls, rows: tuple[Row, ...]) -> tuple[Row, ...]:
        degree = isqrt(len(rows)) - 1
        if not rows or len(rows) != (degree + 1) ** 2 or degree > HIGHEST_DEGREE:
            raise ValueError(f"{len(rows)} coefficients are no whole number of bands")
        return rows


class LightsFile(Strict):
    """The whole file."""

    format: Literal["r3gw-lights"] = "r3gw-lights"
    version: Literal[1, 2] = 1
    convention: dict[str, str] = CONVENTION
    coordinates: Literal["scene", "source"]
    photos: dict[str, Coefficients]


def write_lights(
    lights: Mapping[str, Light], coordinates: Literal["scene", "source"], folder: Path
) -> None:
    """Write ``folder/lights.json``; float32 values survive exactly.

    Args:
        lights: As training learned them: each with a `LearnedSky` of exposure 1.
        coordinates: In whose frame directions are; see `CONVENTION`.
        folder: Where the file goes.
    """
    photos: dict[str, dict[str, Any]] = {
        photo: {"light": light.sh.tolist(), "sky": _sky(photo, light).tolist()}
        for photo, light in lights.items()
    }
    content: dict[str, Any] = {"coordinates": coordinates, "photos": photos}
    for photo, light in lights.items():
        if light.point is not None:
            content |= {"version": 2, "convention": CONVENTION | SUN_CONVENTION}
            entry = {"direction": light.point.direction, "irradiance": light.point.irradiance}
            photos[photo]["sun"] = {name: value.tolist() for name, value in entry.items()}
    checked = LightsFile.model_validate(content)
    write_json(folder / NAME, checked.model_dump(mode="json", exclude_none=True))


def _sky(photo: str, light: Light) -> Float[Tensor, "skycoeff 3"]:
    if light.sky_coefficients is None:
        raise ValueError(f"the light of photo '{photo}' has no learned sky to write")
    return light.sky_coefficients


def read_lights(folder: Path) -> dict[str, Light]:
    """Read ``folder/lights.json``; no file means no lights.

    Raises:
        InputError: If the file is malformed.
    """
    path = folder / NAME
    if not path.is_file():
        return {}
    content = validated(LightsFile, read_json(path), str(path))
    return {
        photo: Light(
            torch.tensor(entry.light), LearnedSky(torch.tensor(entry.sky)), _point(entry.sun)
        )
        for photo, entry in content.photos.items()
    }


def _point(sun: SunEntry | None) -> PointSun | None:
    if sun is None:
        return None
    return PointSun(torch.tensor(sun.direction), torch.tensor(sun.irradiance))
