"""Point clouds in PLY files, as nerfstudio keeps them beside transforms.json; pycolmap reads."""

import tempfile
from pathlib import Path

import numpy as np
import pycolmap

from r3gw.files import InputError
from r3gw.importing.source import SourcePoints

# PLY has two names for each type, and pycolmap knows one of them.
_ALIASES = ((b" uint8 ", b" uchar "), (b" float32 ", b" float "), (b" float64 ", b" double "))
_END = b"end_header"


def read_ply_points(path: Path) -> SourcePoints:
    """Positions and colours of a PLY file; points without a colour are black.

    Raises:
        InputError: If the file is missing or damaged, or holds no points or points at NaN.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file; put the point cloud in place")
    header, end, content = path.read_bytes().partition(_END)
    for alias, known in _ALIASES:
        header = header.replace(alias, known)
    model = pycolmap.Reconstruction()
    try:
        with tempfile.TemporaryDirectory(prefix="r3gw-") as folder:
            (Path(folder) / "points.ply").write_bytes(header + end + content)
            model.import_PLY(Path(folder) / "points.ply")
    except (ValueError, RuntimeError, IndexError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{path}: not readable as a PLY point cloud ({reason})") from None
    ordered = [model.points3D[identifier] for identifier in sorted(model.points3D)]
    if not ordered:
        raise InputError(f"{path}: holds no points; make the point cloud again")
    xyz = np.array([point.xyz for point in ordered], dtype=np.float64)
    if not np.isfinite(xyz).all():
        raise InputError(f"{path}: holds points at NaN or infinity; make the point cloud again")
    return SourcePoints(xyz, np.array([point.color for point in ordered], dtype=np.uint8))
