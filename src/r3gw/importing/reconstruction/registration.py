"""What structure from motion made of the photos: how many registered, and why others did not."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pycolmap

from r3gw.importing.gauge import roll_deg, up_direction
from r3gw.importing.reconstruction.prepared import PreparedPhoto
from r3gw.importing.source import SourceView

ADVICE = (
    "take more photos of the same place with more overlap (each part of it in three or more), "
    "or remove photos of other places"
)
LEAST_PHOTOS = 3  # that a scene needs
_LOG = logging.getLogger(__name__)
_FEW_FEATURES = 100
_LEAST_INLIERS = 15  # of a pair that COLMAP's mapper uses


@dataclass(frozen=True)
class Mapped:
    """The outcome of incremental mapping; images are named as the prepared files.

    Attributes:
        chosen: The model with most photos.
        others: The other models.
        database: Features and matches.
        matching: How pairs were chosen, and how many there were.
    """

    chosen: pycolmap.Reconstruction
    others: Sequence[pycolmap.Reconstruction]
    database: Path
    matching: str


def lost_photos(photos: Sequence[PreparedPhoto], mapped: Mapped) -> dict[str, str]:
    """Photos that are not in the chosen model, by path, each with the reason."""
    registered = _names(mapped.chosen)
    return {
        photo.path: _reason(photo.file.name, mapped)
        for photo in photos
        if photo.file.name not in registered
    }


def registration_facts(
    photos: Sequence[PreparedPhoto], mapped: Mapped, views: Sequence[SourceView]
) -> dict[str, object]:
    """How good the model is, logged and for sfm_report.json.

    Args:
        photos: The photos given.
        mapped: The models, of which the largest was chosen.
        views: What was made of it.
    """
    rotations = np.stack([view.camera.cam_from_world[:3, :3].numpy() for view in views])
    rolls = roll_deg(rotations, up_direction(rotations))
    error = float(mapped.chosen.compute_mean_reprojection_error())
    _LOG.info(
        "registered %d of %d photos, %d points, mean reprojection error %.2f px (%s)",
        len(views),
        len(photos),
        mapped.chosen.num_points3D(),
        error,
        mapped.matching,
    )
    if len(views) < len(photos):
        _LOG.warning("photos did not register; %s", ADVICE)
    return {
        "matching": mapped.matching,
        "models": 1 + len(mapped.others),
        "mean_reprojection_error_px": round(error, 4),
        "roll_deg": {
            view.path: round(float(roll), 2) for view, roll in zip(views, rolls, strict=True)
        },
    }


def _names(model: pycolmap.Reconstruction) -> set[str]:
    return {str(image.name) for image in model.images.values() if image.has_pose}


def _reason(name: str, mapped: Mapped) -> str:
    """Why a photo did not register."""
    for model in mapped.others:
        names = _names(model)
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
