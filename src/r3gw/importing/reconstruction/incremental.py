"""Structure from motion of prepared photos: SIFT, matching and incremental mapping by pycolmap.

Every step is seeded, and mapping runs on one thread, because Ceres adds up in the order in which
threads finish: the same photos and seed give the same scene. Photos need no EXIF; where it tells
a focal length, mapping starts from it.
"""

from collections.abc import Sequence
from pathlib import Path

import pycolmap

from r3gw.files import InputError
from r3gw.importing.reader import Effort
from r3gw.importing.reconstruction.at_once import mapped_at_once
from r3gw.importing.reconstruction.matching import Matching, match_photos
from r3gw.importing.reconstruction.prepared import PreparedPhoto, focal_lengths
from r3gw.importing.reconstruction.pycolmap_log import quiet
from r3gw.importing.reconstruction.registration import ADVICE, LEAST_PHOTOS, Mapped

ENOUGH = 0.5  # Share of the photos; with fewer in the largest model, global mapping tries, too.


def reconstruct(
    photos: Sequence[PreparedPhoto],
    source: Path,
    effort: Effort,
    *,
    matching: Matching | None,
    camera_mode: pycolmap.CameraMode,
) -> Mapped:
    """The model with most photos, and the others.

    Args:
        photos: In ``effort.folder / "photos"``; ``keep`` beside it says where features may lie.
        source: The dataset, for errors.
        effort: Working folder, threads and seed.
        matching: How pairs are chosen.
        camera_mode: Who shares a camera.

    Raises:
        InputError: If fewer than three photos register together.
    """
    folder, database = effort.folder, effort.folder / "database.db"
    with quiet():
        _extract_features(photos, folder, database, camera_mode, effort)
        how = match_photos(photos, database, matching, effort)
        options = pycolmap.IncrementalPipelineOptions(num_threads=1, random_seed=effort.seed)
        options.min_model_size = LEAST_PHOTOS
        (folder / "models").mkdir()
        mapping = pycolmap.incremental_mapping(
            database, folder / "photos", folder / "models", options
        )
        models = list(mapping.values())
        if _registered(_largest(models)) < ENOUGH * len(photos):
            others = mapped_at_once(database, folder / "photos", effort.seed)
            if _registered(_largest(others)) > _registered(_largest(models)):
                models, how = others, f"{how}, placed at once"
    largest = _largest(models)
    registered = _registered(largest)
    if largest is None or registered < LEAST_PHOTOS:
        raise InputError(
            f"{source}: only {registered} photos could be registered together, at least "
            f"{LEAST_PHOTOS} are needed; {ADVICE}"
        )
    return Mapped(largest, [model for model in models if model is not largest], database, how)


def _largest(models: Sequence[pycolmap.Reconstruction]) -> pycolmap.Reconstruction | None:
    return max(
        models,
        key=lambda model: (model.num_reg_images(), model.num_points3D()),
        default=None,
    )


def _registered(model: pycolmap.Reconstruction | None) -> int:
    return 0 if model is None else int(model.num_reg_images())


def _extract_features(
    photos: Sequence[PreparedPhoto],
    folder: Path,
    database: Path,
    mode: pycolmap.CameraMode,
    effort: Effort,
) -> None:
    """SIFT features of every photo, where its masks allow."""
    pycolmap.Database.open(database).close()
    pycolmap.set_random_seed(effort.seed)
    # Entered first and in order, so that identifiers do not depend on which thread is done.
    pycolmap.import_images(database, folder / "photos", camera_mode=mode)
    known = focal_lengths(photos)
    with pycolmap.Database.open(database) as opened:
        for image in opened.read_all_images():
            if image.name in known:
                camera = opened.read_camera(image.camera_id)
                camera.focal_length = known[image.name]
                camera.has_prior_focal_length = True
                opened.update_camera(camera)
    options = pycolmap.FeatureExtractionOptions(num_threads=effort.num_threads, use_gpu=False)
    reader = pycolmap.ImageReaderOptions()
    if (folder / "keep").is_dir():
        reader.mask_path = folder / "keep"
    pycolmap.extract_features(
        database,
        folder / "photos",
        camera_mode=mode,
        reader_options=reader,
        extraction_options=options,
    )
