"""Placing all photos at once, for collections on which incremental mapping gives up early.

Incremental mapping begins with two photos, and where their focal lengths are unknown and the camera
moved straight ahead, as along a street, the two tell next to nothing about depth: no third photo
fits. Global mapping (Pan et al., "Global Structure-from-Motion Revisited", ECCV 2024; COLMAP has
it) asks all pairs for focal lengths and rotations before any place is fixed.
"""

import shutil
from pathlib import Path

import pycolmap

SEEN_ENOUGH = 15  # points that a photo must share with others; with fewer it is placed by chance
FOCAL_SIDES = (0.1, 10.0)  # shortest and longest focal length of a camera, in longer sides
LARGEST_DISTORTION = 1.0


def mapped_at_once(database: Path, photos: Path, seed: int) -> list[pycolmap.Reconstruction]:
    """Models of photos whose features are matched; none where they do not fit together.

    Args:
        database: COLMAP's; a copy of it is calibrated, it stays as it is.
        photos: Folder of the photos, for the points' colours.
        seed: Of the random choices; everything runs on one thread.
    """
    folder = database.parent / "at_once"
    folder.mkdir()
    calibrated = folder / "database.db"
    shutil.copy(database, calibrated)
    pycolmap.calibrate_view_graph(
        calibrated, options=pycolmap.ViewGraphCalibrationOptions(random_seed=seed)
    )
    options = pycolmap.GlobalPipelineOptions(num_threads=1, random_seed=seed)
    models = pycolmap.global_mapping(calibrated, photos, folder, options)
    for model in models.values():
        _leave_out_unsure(model)
    return list(models.values())


def _leave_out_unsure(model: pycolmap.Reconstruction) -> None:
    """Take away photos that share too few points with others, or whose camera cannot be."""
    for image in list(model.images.values()):
        is_unsure = image.num_points3D < SEEN_ENOUGH
        is_bogus = image.camera.has_bogus_params(*FOCAL_SIDES, LARGEST_DISTORTION)
        if image.has_pose and (is_unsure or is_bogus):
            model.deregister_frame(image.frame_id)
