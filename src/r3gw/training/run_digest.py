"""What a run depends on, as one digest: two runs of the same digest give the same bytes.

It names the checkpoint, so that a state made of other inputs is never continued, and stands in
run.json. Of photos, masks and points it covers what training reads of them, not the files: a mask
that is made again and comes out the same changes nothing.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import torch
from torch import Tensor

from r3gw.model.initial import InitialPoints
from r3gw.training.photos import Photo

HEX_DIGITS = 16


def run_parts(
    settings: Mapping[str, Any],
    code: str,
    photos: Sequence[Photo],
    sessions: Sequence[str],
    initial: InitialPoints,
    num_threads: int,
) -> dict[str, str]:
    """Digest of each thing that a run depends on, by its name in messages.

    Args:
        settings: All settings of the run.
        code: Digest of r3gw's code.
        photos: The training photos with cameras and masks.
        sessions: The photos' sessions.
        initial: What both sets start from.
        num_threads: CPU threads, which decide the order of some sums.
    """
    dome = initial.dome
    points = (initial.foreground, initial.sky_angles, dome.centre)
    return {
        "settings": _digest([json.dumps(settings, sort_keys=True)]),
        "code": _digest([code, f"torch {torch.__version__}"]),
        "photos": _digest(_photo_items(photos, sessions)),
        "masks": _digest(mask for photo in photos for mask in (photo.is_valid, photo.is_sky)),
        "initial points": _digest([*points, repr((dome.radius, dome.azimuth_rad))]),
        "threads": str(num_threads),
    }


def run_digest(parts: Mapping[str, str]) -> str:
    """One digest of all `run_parts`."""
    return _digest([json.dumps(parts, sort_keys=True)])


def _photo_items(photos: Sequence[Photo], sessions: Sequence[str]) -> Iterable[str | Tensor]:
    for photo, session in zip(photos, sessions, strict=True):
        camera = photo.camera
        sun = None if photo.known_sun is None else photo.known_sun.tolist()
        yield json.dumps([photo.name, session, camera.width, camera.height, camera.intrinsics, sun])
        yield from (camera.cam_from_world, photo.planes)
        if photo.normals is not None:
            yield photo.normals


def _digest(items: Iterable[str | Tensor]) -> str:
    """SHA-256 over strings and arrays, each with its length or its shape."""
    found = hashlib.sha256()
    for item in items:
        if isinstance(item, str):
            found.update(f"{len(item)} {item}".encode())
        else:
            found.update(f"{item.dtype} {tuple(item.shape)}".encode())
            found.update(item.detach().contiguous().numpy().data)
    return found.hexdigest()[:HEX_DIGITS]
