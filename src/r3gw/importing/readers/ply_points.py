"""Point clouds in PLY files, as nerfstudio keeps them beside transforms.json, or any scanner."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.files.ply import read_vertices
from r3gw.importing.source import SourcePoints

_POSITION = ("x", "y", "z")
_COLOURS = (
    ("red", "green", "blue"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
    ("r", "g", "b"),
)


def read_ply_points(path: Path) -> SourcePoints:
    """Positions and colours of a PLY file's vertices; points without a colour are black.

    Colours of whole numbers fill the range of their type; floats are taken as 0 to 1, or as 0 to
    255 if one is above 1.

    Raises:
        InputError: If the file is missing or damaged, or holds no points or points at NaN.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file; put the point cloud in place")
    try:
        rows, _ = read_vertices(path)
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{path}: not readable as a PLY point cloud ({reason})") from None
    names = rows.dtype.names or ()
    if not set(_POSITION) <= set(names):
        raise InputError(
            f"{path}: its vertices have no x, y and z ({', '.join(names[:12])}); make the point "
            "cloud again"
        )
    if not len(rows):
        raise InputError(f"{path}: holds no points; make the point cloud again")
    xyz = np.stack([rows[name].astype(np.float64) for name in _POSITION], axis=-1)
    if not np.isfinite(xyz).all():
        raise InputError(f"{path}: holds points at NaN or infinity; make the point cloud again")
    return SourcePoints(xyz, _colours(rows, path))


def _colours(rows: NDArray[Any], path: Path) -> NDArray[np.uint8]:
    names = rows.dtype.names or ()
    found = next((colours for colours in _COLOURS if set(colours) <= set(names)), None)
    if found is None:
        return np.zeros((len(rows), 3), np.uint8)
    values = np.stack([rows[name] for name in found], axis=-1)
    if values.dtype == np.uint8:
        return values.astype(np.uint8)
    scaled = values.astype(np.float64)
    if not np.isfinite(scaled).all():
        raise InputError(f"{path}: holds colours at NaN or infinity; make the point cloud again")
    if values.dtype == np.uint16:
        scaled /= 257.0
    elif values.dtype.kind == "f" and scaled.max() <= 1.0:
        scaled *= 255.0
    return np.rint(np.clip(scaled, 0.0, 255.0)).astype(np.uint8)
