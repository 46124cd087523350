"""Does single precision carry the scene? Training computes in it, so coordinates must be small.

Coordinates of maps (UTM, ECEF) count millions of metres, and float32 has seven digits. They are
kept in float64 until the gauge has centred and scaled them; with ``extent: null`` nothing does.
"""

from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.geometry.similarity import Similarity
from r3gw.importing.source import SourceScene, SourceView

_MOST_PX = 0.1  # of a point's place in a photo, in one of a hundred cases
_SAMPLES = 2000
_PERCENTILE = 99


def require_single_precision(source: SourceScene, similarity: Similarity, path: Path) -> None:
    """Refuse coordinates that float32 moves by more than 0.1 px in the photos.

    Args:
        source: Views and points in the source's frame.
        similarity: ``scene_from_source``.
        path: The dataset, for the error.

    Raises:
        InputError: Stating how far points move, and the remedy.
    """
    step = max(1, len(source.points.xyz) // _SAMPLES)
    xyz = similarity.points(torch.from_numpy(source.points.xyz[::step])).numpy()
    shifts = np.concatenate([_shifts_px(view, xyz, similarity) for view in source.views])
    if not len(shifts):
        return
    shift = float(np.percentile(shifts, _PERCENTILE))
    if not shift <= _MOST_PX:
        raise InputError(
            f"{path}: coordinates reach {np.abs(xyz).max():.3g} units, which single precision "
            f"moves by {shift:.2g} px in the photos; set 'extent' (for example 10) in the scene's "
            "entry, which centres and scales them (scene.json keeps the way back)"
        )


def _shifts_px(
    view: SourceView, xyz: NDArray[np.float64], similarity: Similarity
) -> NDArray[np.float64]:
    """How far points before the camera move in the photo if all is computed in float32."""
    pose = similarity.camera(view.camera.cam_from_world).numpy()
    exact = xyz @ pose[:3, :3].T + pose[:3, 3]
    with np.errstate(over="ignore"):
        single = pose.astype(np.float32)
        rounded = xyz.astype(np.float32) @ single[:3, :3].T + single[:3, 3]
    fx, fy, cx, cy = view.camera.intrinsics
    size = np.array([view.camera.width, view.camera.height])
    with np.errstate(all="ignore"):
        places = [
            p[:, :2] / p[:, 2:] * [fx, fy] + [cx, cy] for p in (exact, rounded.astype(np.float64))
        ]
        inside = (exact[:, 2] > 0) & ((places[0] >= 0) & (places[0] <= size)).all(axis=1)
        distance: NDArray[np.float64] = np.linalg.norm(places[0] - places[1], axis=1)
    seen: NDArray[np.float64] = np.nan_to_num(distance[inside], nan=np.inf)
    return seen
