"""The photos that a page asks which uncovered places are dark (web/src/witnesses.ts)."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from r3gw.geometry.cameras import Camera
from r3gw.relight.gaussians import Relightable
from r3gw.relight.witnesses import MAP_LEVELS, MAP_PX, Witnesses
from r3gw.scene.selection import evenly

MOST_WITNESSES = 60  # A map is 16 KiB in the browser, and some 2 KiB in the page.


def witness_records(
    gaussians: Relightable, cameras: Sequence[Camera]
) -> tuple[dict[str, Any], bytes]:
    """`WitnessRecords` of web/src/payload.ts, and the bytes of their maps.

    Args:
        gaussians: What was trained, whole.
        cameras: Cameras of the training photos, the first of the page's photos.
    """
    chosen = evenly(range(len(cameras)), MOST_WITNESSES) if gaussians.num_foreground else []
    asked = Witnesses(gaussians, [cameras[i] for i in chosen])
    maps = [asked.map_of(i).numpy() * MAP_LEVELS for i in range(len(chosen))]
    dome = gaussians.dome
    records = {
        "photos": list(chosen),
        "reaches": asked.reaches(),
        "dome": None if dome is None else [*dome.centre.tolist(), dome.radius],
        "size": MAP_PX,
    }
    return records, b"".join(np.rint(each).astype(np.uint8).tobytes() for each in maps)
