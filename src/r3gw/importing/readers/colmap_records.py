"""What COLMAP's three model files hold, as plain values: no object of pycolmap among them.

Both forms, text and binary, are read here rather than by pycolmap, which ends the process on a
file that is cut off, takes quaternions of any length and drops every second image of a text file
that lacks the lines of points. Format: colmap.github.io/format.html.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from r3gw.importing.lens import Lens

Numbers = tuple[int | float, ...]


class StoredImage(NamedTuple):
    """One posed image: ``cam_from_world`` as a quaternion ``wxyz`` and a translation."""

    name: str
    quaternion: Numbers
    translation: Numbers
    camera_id: int


@dataclass(frozen=True)
class StoredModel:
    """A model as it lies on disk, unchecked.

    Attributes:
        lenses: Cameras by their id.
        images: Posed images, in the order of the file.
        xyz: Positions ``[N, 3]`` of the points, in the order of their ids.
        rgb: Their colours ``[N, 3]``.
    """

    lenses: dict[int, Lens]
    images: list[StoredImage]
    xyz: NDArray[np.float64]
    rgb: NDArray[np.uint8]


def ordered_points(
    points: dict[int, Numbers],
) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Positions and colours of ``(x, y, z, red, green, blue)`` by id, in the order of ids."""
    rows = np.array([points[identifier] for identifier in sorted(points)], dtype=np.float64)
    rows = rows.reshape(-1, 6)
    return rows[:, :3].copy(), np.clip(np.nan_to_num(rows[:, 3:]), 0, 255).astype(np.uint8)
