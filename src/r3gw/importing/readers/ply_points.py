"""Point clouds in PLY files, as nerfstudio keeps them beside transforms.json, or any scanner."""

from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.files.ply import read_vertices
from r3gw.importing.source import SourcePoints

_POSITION = ("x", "y", "z")
_HARMONICS = ("f_dc_0", "f_dc_1", "f_dc_2")  # what Gaussian splats have for a colour
_CONSTANT_HARMONIC = 0.5 / sqrt(pi)
_COLOURS = (
    ("red", "green", "blue"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
    ("r", "g", "b"),
)


def read_ply_points(path: Path) -> SourcePoints:
    """Positions and colours of a PLY file's vertices; points without a colour are black.

    Names may be in upper case. Colours of whole numbers fill the range of their type; floats are
    taken as 0 to 1, or as 0 to 255 if one is above 1. Gaussian splats have the colour that their
    constant spherical harmonic gives.

    Raises:
        InputError: If the file is missing or damaged, or holds no points or points at NaN.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file; put the point cloud in place")
    try:
        rows, _ = read_vertices(path)
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise InputError(
            f"{path}: not readable as a PLY point cloud ({reason}); save it again"
        ) from None
    names = rows.dtype.names or ()
    if len({name.lower() for name in names}) == len(names):
        rows = rows.view([(name.lower(), rows.dtype[name]) for name in names])
    if not set(_POSITION) <= set(rows.dtype.names or ()):
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
    known = (*_COLOURS, _HARMONICS)
    found = next((colours for colours in known if set(colours) <= set(names)), None)
    if found is None:
        return np.zeros((len(rows), 3), np.uint8)
    values = np.stack([rows[name] for name in found], axis=-1)
    if values.dtype == np.uint8:
        return values.astype(np.uint8)
    scaled = values.astype(np.float64)
    if not np.isfinite(scaled).all():
        raise InputError(f"{path}: holds colours at NaN or infinity; make the point cloud again")
    if found == _HARMONICS:
        scaled = 255.0 * (0.5 + _CONSTANT_HARMONIC * scaled)
    elif values.dtype == np.uint16:
        scaled /= 257.0
    elif values.dtype.kind == "f" and scaled.max() <= 1.0:
        scaled *= 255.0
    return np.rint(np.clip(scaled, 0.0, 255.0)).astype(np.uint8)
