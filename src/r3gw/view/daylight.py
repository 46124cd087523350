"""Tables from which the page makes `r3gw.lighting.daylight.clear_day` itself (web/src/daylight.ts).

The sky is Hosek and Wilkie's formula (SIGGRAPH 2012), of which nine parameters and a radiance per
colour channel are given at ten turbidities and six control points over the sun's elevation. They
come from the data set that Mitsuba carries (BSD licence; its text goes into the page). The sun's
irradiance is sampled from `r3gw.lighting.daylight`.

The tables lie in the package, so that a page needs no Mitsuba; ``python -m r3gw.view.daylight``
makes them anew, and a test holds them against Mitsuba.
"""

import json
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from r3gw.files import atomic_path
from r3gw.files.extras import optional_module
from r3gw.lighting.daylight import GROUND_ALBEDO, SKY_SCALE, Sun, sun_irradiance

TURBIDITIES = 10
SUN_SAMPLES = 48  # over elevation = 90 (i / 47)^2 degrees: dense at the horizon
LOWEST_DEG = 0.01  # On the horizon itself Mitsuba takes the sun away.
# What the formula's RGB values are divided by: the integral of CIE's luminosity function.
LUMINOSITY_INTEGRAL = 106.7502593994140625
BUNDLE = Path(__file__).parent / "bundle"
TABLES, LICENCE = BUNDLE / "daylight.json", BUNDLE / "HOSEK_WILKIE.txt"


def daylight_tables() -> dict[str, Any]:
    """The tables by the name that web/src/payload.ts gives them.

    Returns:
        ``params`` ``[10, 6, 3, 9]``, ``radiance`` ``[10, 6, 3]`` (turbidity 1 to 10, control point,
        channel) with the ground's albedo and `SKY_SCALE` put in, ``sunIrradiance`` ``[10, 48, 3]``,
        and ``ground`` ``[3]``; all as nested lists.
    """
    tables: dict[str, Any] = json.loads(TABLES.read_text())
    return tables


def make_tables() -> dict[str, Any]:
    """`daylight_tables` from Mitsuba's data.

    Raises:
        InputError: If Mitsuba is not installed.
    """
    fields = _mitsubas("sunsky_datasets.bin")
    radiance = _above_ground(fields["sky_rad_rgb"], axis=-1)
    return {
        "params": _lists(_above_ground(fields["sky_params_rgb"], axis=-2)),
        "radiance": _lists(SKY_SCALE / LUMINOSITY_INTEGRAL * radiance),
        "sunIrradiance": _lists(_sun_table()),
        "ground": GROUND_ALBEDO.tolist(),
    }


def _data_folder() -> Path:
    mitsuba = optional_module("mitsuba")
    return Path(str(mitsuba.__file__)).parent / "data" / "sunsky"


def _mitsubas(name: str) -> dict[str, NDArray[np.float64]]:
    """The arrays of one of Mitsuba's files, by name."""
    path = str(_data_folder() / name)
    with redirect_stdout(StringIO()):  # Mitsuba's reader announces every file.
        fields = optional_module("mitsuba").tensor_io.read(path)
    return {key: np.asarray(value) for key, value in fields.items()}


def _above_ground(values: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    """Interpolate between the albedos 0 and 1 (the second axis), per channel (``axis``)."""
    shape = [1] * (values.ndim - 1)
    shape[axis] = len(GROUND_ALBEDO)
    albedo = GROUND_ALBEDO.reshape(shape)
    return (1 - albedo) * values[:, 0] + albedo * values[:, 1]


def _sun_table() -> NDArray[np.float64]:
    elevations = np.maximum(90.0 * np.linspace(0.0, 1.0, SUN_SAMPLES) ** 2, LOWEST_DEG)
    rows = [
        [sun_irradiance(Sun(0.0, float(e), float(turbidity))) for e in elevations]
        for turbidity in range(1, TURBIDITIES + 1)
    ]
    return np.array(rows)


def _lists(values: NDArray[np.float64]) -> Any:
    """Nested lists of numbers with seven digits: more than float32 keeps."""
    return np.vectorize(lambda x: float(f"{x:.7g}"))(values).tolist()


if __name__ == "__main__":
    with atomic_path(TABLES) as temporary:
        temporary.write_text(json.dumps(make_tables(), separators=(",", ":")))
    with atomic_path(LICENCE) as temporary:
        temporary.write_text((_data_folder() / "LICENSE").read_text())
