"""What structure from motion made of the photos: how many registered, and why others did not."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pycolmap

from r3gw.importing.gauge import roll_deg, up_direction
from r3gw.importing.named_files import listed
from r3gw.importing.source import SourceScene

ADVICE = (
    "take more photos of the same place with more overlap (each part of it in three or more), "
    "or remove photos of other places"
)
_LOG = logging.getLogger(__name__)
_FEW_FEATURES = 100
_LEAST_INLIERS = 15  # of a pair that COLMAP's mapper uses


@dataclass(frozen=True)
class Mapped:
    """The outcome of incremental mapping; images are named ``<stem>.png``."""

    chosen: pycolmap.Reconstruction
    others: Sequence[pycolmap.Reconstruction]
    database: Path


def registration_report(
    photos: Mapping[str, Path], mapped: Mapped, found: SourceScene
) -> dict[str, object]:
    """What registered and what did not, logged and for sfm_report.json.

    Args:
        photos: The photos given, by key.
        mapped: The models, of which the largest was chosen.
        found: What was made of it.
    """
    registered = {view.name for view in found.views}
    lost = {
        path.name: reason
        for path in sorted(photos.values())
        if path.stem not in registered and (reason := _reason(path, mapped))
    }
    rotations = np.stack([view.camera.cam_from_world[:3, :3].numpy() for view in found.views])
    rolls = roll_deg(rotations, up_direction(rotations))
    error = float(mapped.chosen.compute_mean_reprojection_error())
    _LOG.info(
        "registered %d of %d photos, %d points, mean reprojection error %.2f px",
        len(registered),
        len(photos),
        len(found.points.xyz),
        error,
    )
    if lost:
        reasons = listed(f"{name}: {reason}" for name, reason in lost.items())
        _LOG.warning("not registered, left out (%s); %s", reasons, ADVICE)
    return {
        "photos": len(photos),
        "registered": [view.name for view in found.views],
        "not_registered": lost,
        "models": 1 + len(mapped.others),
        "points": len(found.points.xyz),
        "mean_reprojection_error_px": round(error, 4),
        "roll_deg": {
            view.name: round(float(roll), 2) for view, roll in zip(found.views, rolls, strict=True)
        },
    }


def _reason(photo: Path, mapped: Mapped) -> str:
    """Why a photo did not register."""
    name = f"{photo.stem}.png"
    for model in mapped.others:
        names = [image.name for image in model.images.values() if image.has_pose]
        if name in names:
            return f"belongs to another group of {len(names)} photos that does not connect"
    with pycolmap.Database.open(mapped.database) as database:
        image = database.read_image_with_name(name)
        identifier = 0 if image is None else image.image_id
        features = database.num_keypoints_for_image(identifier)
        pairs, inliers = database.read_two_view_geometry_num_inliers()
    if features < _FEW_FEATURES:
        return f"only {features} features (blurred, plain or masked)"
    partners = sum(
        count >= _LEAST_INLIERS and identifier in pycolmap.pair_id_to_image_pair(pair)
        for pair, count in zip(pairs, inliers, strict=True)
    )
    if not partners:
        return "matches no other photo"
    return f"matches {partners} photos, but too few of the points that the others share"
