"""Reader of anybody's own photos: SIFT, matching, incremental mapping, undistortion by pycolmap.

Every step is seeded, and mapping runs on one thread, because Ceres adds up in the order in which
threads finish: the same photos and seed give the same scene. Photos need no EXIF; where it tells
a focal length, mapping starts from it, and its orientation is baked in first.
"""

import logging
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pycolmap
from tqdm import tqdm

from r3gw.files import InputError, write_json
from r3gw.imaging.files import read_rgb, write_image
from r3gw.sfm.colmap_model import read_model
from r3gw.sfm.gauge import roll_deg, up_direction
from r3gw.sfm.named_files import key_of, listed, pictures_by_key
from r3gw.sfm.source import SourceScene, SourceView

_LOG = logging.getLogger(__name__)
_LEAST = 3  # photos that a scene needs
_ADVICE = (
    "take more photos of the same place with more overlap (each part of it in three or more), "
    "or remove photos of other places"
)


@contextmanager
def undistorted_photos(
    source: Path,
    target: Path,
    *,
    matching: Literal["exhaustive", "sequential"],
    num_threads: int,
    seed: int,
) -> Iterator[SourceScene]:
    """Register the photos below ``source`` and yield them undistorted, in COLMAP's own frame.

    The files live in a temporary folder in ``target`` while the context is open; only
    ``target/sfm_report.json`` stays.

    Raises:
        InputError: If a photo is unreadable, two share a stem, or fewer than three register.
    """
    photos = pictures_by_key(source)
    if len(photos) < _LEAST:
        raise InputError(f"{source}: {len(photos)} photos here, but at least {_LEAST} are needed")
    with tempfile.TemporaryDirectory(prefix=".sfm-", dir=target) as folder:
        work = _Work(Path(folder), source, num_threads, seed)
        with _quiet():
            focal_lengths = work.bake_orientation(photos)
            work.extract_features(focal_lengths)
            work.match(matching)
            model, count = work.map()
            work.undistort(model)
            found = work.read()
        report = _report(photos, model, count, found)
        write_json(target / "sfm_report.json", report)
        yield found


@dataclass(frozen=True)
class _Work:
    """One run of SfM in a temporary folder."""

    folder: Path
    source: Path
    num_threads: int
    seed: int

    @property
    def photos(self) -> Path:
        """Photos as pycolmap gets them: upright, without EXIF."""
        return self.folder / "photos"

    @property
    def database(self) -> Path:
        """Features and matches."""
        return self.folder / "database.db"

    def bake_orientation(self, photos: Mapping[str, Path]) -> dict[str, float]:
        """Write every photo upright as PNG; return the focal lengths (px) that EXIF tells."""
        focal_lengths = {}
        for path in tqdm(photos.values(), desc="reading photos", unit="photo", leave=False):
            write_image(self.photos / f"{path.stem}.png", read_rgb(path))
            camera = pycolmap.infer_camera_from_image(path)
            if camera.has_prior_focal_length:
                focal_lengths[f"{path.stem}.png"] = float(camera.mean_focal_length())
        return focal_lengths

    def extract_features(self, focal_lengths: Mapping[str, float]) -> None:
        """SIFT features of every photo; each has a camera of its own."""
        pycolmap.Database.open(self.database).close()
        pycolmap.set_random_seed(self.seed)
        # Entered first and in order, so that identifiers do not depend on which thread is done.
        pycolmap.import_images(
            self.database, self.photos, camera_mode=pycolmap.CameraMode.PER_IMAGE
        )
        with pycolmap.Database.open(self.database) as database:
            for image in database.read_all_images():
                if image.name in focal_lengths:
                    camera = database.read_camera(image.camera_id)
                    camera.focal_length = focal_lengths[image.name]
                    camera.has_prior_focal_length = True
                    database.update_camera(camera)
        options = pycolmap.FeatureExtractionOptions(num_threads=self.num_threads, use_gpu=False)
        pycolmap.extract_features(self.database, self.photos, extraction_options=options)

    def match(self, matching: Literal["exhaustive", "sequential"]) -> None:
        """Match all pairs of photos, or neighbours in the order of their names."""
        verification = pycolmap.TwoViewGeometryOptions()
        verification.ransac.random_seed = self.seed
        options = pycolmap.FeatureMatchingOptions(num_threads=self.num_threads, use_gpu=False)
        if matching == "exhaustive":
            pycolmap.match_exhaustive(
                self.database, matching_options=options, verification_options=verification
            )
        else:
            pycolmap.match_sequential(
                self.database, matching_options=options, verification_options=verification
            )

    def map(self) -> tuple[pycolmap.Reconstruction, int]:
        """The model with most photos, and how many models there were."""
        options = pycolmap.IncrementalPipelineOptions(num_threads=1, random_seed=self.seed)
        options.min_model_size = _LEAST
        output = self.folder / "models"
        output.mkdir()
        models = pycolmap.incremental_mapping(self.database, self.photos, output, options)
        largest = max(
            models.values(),
            key=lambda model: (model.num_reg_images(), model.num_points3D()),
            default=None,
        )
        if largest is None or largest.num_reg_images() < _LEAST:
            registered = 0 if largest is None else largest.num_reg_images()
            raise InputError(
                f"{self.source}: only {registered} photos could be registered together, at least "
                f"{_LEAST} are needed; {_ADVICE}"
            )
        return largest, len(models)

    def undistort(self, model: pycolmap.Reconstruction) -> None:
        """Write pinhole photos and their model."""
        chosen = self.folder / "chosen"
        chosen.mkdir()
        model.write_binary(chosen)
        pycolmap.undistort_images(
            self.folder / "undistorted", chosen, self.photos, num_threads=self.num_threads
        )

    def read(self) -> SourceScene:
        """The undistorted photos with their cameras, all for training."""
        model = read_model(self.folder / "undistorted" / "sparse")
        photos = self.folder / "undistorted" / "images"
        views = tuple(
            SourceView(Path(name).stem, photos / name, model.cameras[name], "train")
            for name in sorted(model.cameras)
        )
        return SourceScene(views, model.points)


def _report(
    photos: Mapping[str, Path],
    model: pycolmap.Reconstruction,
    num_models: int,
    found: SourceScene,
) -> dict[str, object]:
    """What registered and what did not, logged and for sfm_report.json."""
    registered = {key_of(view.name) for view in found.views}
    lost = sorted(path.name for key, path in photos.items() if key not in registered)
    rotations = np.stack([view.camera.cam_from_world[:3, :3].numpy() for view in found.views])
    rolls = roll_deg(rotations, up_direction(rotations))
    error = model.compute_mean_reprojection_error()
    _LOG.info(
        "registered %d of %d photos, %d points, mean reprojection error %.2f px",
        len(registered),
        len(photos),
        len(found.points.xyz),
        error,
    )
    if lost:
        _LOG.warning("not registered, left out: %s; %s", listed(lost), _ADVICE)
    return {
        "photos": len(photos),
        "registered": [view.name for view in found.views],
        "not_registered": lost,
        "models": num_models,
        "points": len(found.points.xyz),
        "mean_reprojection_error_px": round(float(error), 4),
        "roll_deg": {
            view.name: round(float(roll), 2) for view, roll in zip(found.views, rolls, strict=True)
        },
    }


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep pycolmap's progress messages off the terminal; errors stay."""
    level = pycolmap.logging.minloglevel
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value
    try:
        yield
    finally:
        pycolmap.logging.minloglevel = level
