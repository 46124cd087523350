"""Initial points for photos with known cameras but no sparse model: SIFT, matching, triangulation.

pycolmap does the work and the cameras stay as given. Pairs are chosen by pose, since all pairs of
some hundred photos take hours: every photo is matched with those next to it that look the same way.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pycolmap
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.imaging.files import read_rgb_as_stored, write_image
from r3gw.importing.lens import undistorted
from r3gw.importing.readers.colmap_model import from_reconstruction
from r3gw.importing.reconstruction.pycolmap_log import quiet
from r3gw.importing.source import SourceView
from r3gw.scene import Points

_NEIGHBOURS = 20
_LEAST_POINTS = 50


def triangulated_points(
    views: Sequence[SourceView], source: Path, *, num_threads: int, seed: int
) -> Points:
    """Points that the photos of ``views`` share, in the source's frame.

    Args:
        views: Photos with their cameras; they are not changed.
        source: The dataset, for error messages.
        num_threads: For features and matching.
        seed: For the random sampling in the verification of matches.

    Raises:
        InputError: If fewer than 50 points come out.
    """
    with tempfile.TemporaryDirectory(prefix="r3gw-") as name, quiet():
        work = Path(name)
        for index, view in enumerate(tqdm(views, desc="reading photos", leave=False)):
            photo = read_rgb_as_stored(view.photo)
            if view.lens is not None:
                photo = undistorted(photo, view.lens)
            write_image(work / "photos" / _name(index), photo)
        known = _enter(views, work, num_threads)
        _match(views, work, num_threads, seed)
        (work / "model").mkdir()
        options = pycolmap.IncrementalPipelineOptions(num_threads=1, random_seed=seed)
        model = pycolmap.triangulate_points(
            known, work / "database.db", work / "photos", work / "model", options=options
        )
        if len(model.points3D) < _LEAST_POINTS:
            raise InputError(
                f"{source}: only {len(model.points3D)} points could be triangulated from the "
                f"photos, at least {_LEAST_POINTS} are needed; check that poses and intrinsics "
                "belong to the photos, or import the photos alone as 'photos'"
            )
        return from_reconstruction(model, source).points


def neighbours(views: Sequence[SourceView], count: int = _NEIGHBOURS) -> list[tuple[int, int]]:
    """Pairs of views to match, by index: each with the ``count`` nearest that look its way.

    Views whose axes are more than 90 degrees apart are no pair.
    """
    centres = np.stack([view.camera.centre.numpy() for view in views])
    forward = np.stack([view.camera.cam_from_world[2, :3].numpy() for view in views])
    pairs = set()
    for index in range(len(views)):
        distance = np.linalg.norm(centres - centres[index], axis=1)
        distance[forward @ forward[index] <= 0] = np.inf
        distance[index] = np.inf
        nearest = np.argsort(distance, kind="stable")[:count]
        pairs |= {
            (min(index, int(other)), max(index, int(other)))
            for other in nearest
            if np.isfinite(distance[other])
        }
    return sorted(pairs)


def _name(index: int) -> str:
    """A file name that a list of pairs can hold: the photos' own may have blanks."""
    return f"{index:06d}.png"


def _enter(views: Sequence[SourceView], work: Path, num_threads: int) -> pycolmap.Reconstruction:
    """Enter photos, cameras and features in a database; return the model of known poses."""
    path = work / "database.db"
    pycolmap.Database.open(path).close()
    options = pycolmap.ImageReaderOptions(camera_model="PINHOLE")
    mode = pycolmap.CameraMode.PER_IMAGE
    pycolmap.import_images(path, work / "photos", camera_mode=mode, options=options)
    by_name = {_name(index): view for index, view in enumerate(views)}
    known = pycolmap.Reconstruction()
    with pycolmap.Database.open(path) as database:
        for image in database.read_all_images():
            view = by_name[image.name]
            camera = database.read_camera(image.camera_id)
            camera.params = list(view.camera.intrinsics)
            camera.has_prior_focal_length = True
            database.update_camera(camera)
            known.add_camera_with_trivial_rig(camera)
            entry = pycolmap.Image(
                name=image.name, camera_id=image.camera_id, image_id=image.image_id
            )
            pose = pycolmap.Rigid3d(view.camera.cam_from_world[:3].numpy())
            known.add_image_with_trivial_frame(entry, pose)
    extraction = pycolmap.FeatureExtractionOptions(num_threads=num_threads, use_gpu=False)
    pycolmap.extract_features(path, work / "photos", extraction_options=extraction)
    return known


def _match(views: Sequence[SourceView], work: Path, num_threads: int, seed: int) -> None:
    lines = [f"{_name(first)} {_name(second)}" for first, second in neighbours(views)]
    (work / "pairs.txt").write_text("\n".join(lines) + "\n")
    verification = pycolmap.TwoViewGeometryOptions()
    verification.ransac.random_seed = seed
    pycolmap.match_image_pairs(
        work / "database.db",
        matching_options=pycolmap.FeatureMatchingOptions(num_threads=num_threads, use_gpu=False),
        pairing_options=pycolmap.ImportedPairingOptions(match_list_path=work / "pairs.txt"),
        verification_options=verification,
    )
