"""Initial points for photos with known cameras but no sparse model: SIFT, matching, triangulation.

pycolmap does the work and the cameras stay as given. Pairs are chosen by pose, since all pairs of
some hundred photos take hours: every photo is matched with those next to it that look the same way.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pycolmap
from numpy.typing import NDArray
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.imaging.files import write_image
from r3gw.importing.lens import undistorted
from r3gw.importing.reader import Effort
from r3gw.importing.reconstruction.copied import from_reconstruction
from r3gw.importing.reconstruction.matching import match_pairs
from r3gw.importing.reconstruction.pycolmap_log import quiet
from r3gw.importing.source import SourcePoints, SourceView
from r3gw.importing.stored import stored_photo

_NEIGHBOURS = 20
_LEAST_POINTS = 50


def with_points(
    views: Sequence[SourceView], points: SourcePoints, source: Path, effort: Effort
) -> tuple[SourcePoints, tuple[str, ...]]:
    """``points``, or triangulated ones if there are none; and a sentence in that case.

    Raises:
        InputError: As `triangulated_points`.
    """
    if len(points.xyz):
        return points, ()
    found = triangulated_points(views, source, effort)
    return found, (
        f"the model has known cameras but no 3D points: {len(found.xyz)} were triangulated",
    )


def triangulated_points(views: Sequence[SourceView], source: Path, effort: Effort) -> SourcePoints:
    """Points that the photos of ``views`` share, in the source's frame.

    Args:
        views: Photos with their cameras; they are not changed.
        source: The dataset, for error messages.
        effort: Where temporary files go, threads, and the seed for the verification of matches.

    Raises:
        InputError: If fewer than 50 points come out.
    """
    work = effort.folder / "triangulation"
    with quiet():
        for index, view in enumerate(tqdm(views, desc="reading photos", leave=False)):
            photo = stored_photo(view)
            if view.lens is not None:
                photo = undistorted(photo, view.lens)
            write_image(work / "photos" / _name(index), photo)
        centre = _middle(views)
        known = _enter(views, centre, work, effort.num_threads)
        _match(views, work, effort)
        (work / "model").mkdir()
        options = pycolmap.IncrementalPipelineOptions(num_threads=1, random_seed=effort.seed)
        model = pycolmap.triangulate_points(
            known, work / "database.db", work / "photos", work / "model", options=options
        )
        if len(model.points3D) < _LEAST_POINTS:
            raise InputError(
                f"{source}: only {len(model.points3D)} points could be triangulated from the "
                f"photos, at least {_LEAST_POINTS} are needed; check that poses and intrinsics "
                "belong to the photos, or import the photos alone as 'photos'"
            )
        found = from_reconstruction(model, source).points
        return SourcePoints(found.xyz + centre, found.rgb)


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


def _middle(views: Sequence[SourceView]) -> NDArray[np.float64]:
    """The cameras' mean: positions are counted from there, since they may be millions of metres."""
    centres = np.stack([view.camera.centre.numpy() for view in views])
    middle: NDArray[np.float64] = centres.mean(axis=0)
    return middle


def _enter(
    views: Sequence[SourceView], middle: NDArray[np.float64], work: Path, num_threads: int
) -> pycolmap.Reconstruction:
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
            matrix = view.camera.cam_from_world[:3].numpy().copy()
            matrix[:, 3] += matrix[:, :3] @ middle
            pose = pycolmap.Rigid3d(matrix)
            known.add_image_with_trivial_frame(entry, pose)
    extraction = pycolmap.FeatureExtractionOptions(num_threads=num_threads, use_gpu=False)
    pycolmap.extract_features(path, work / "photos", extraction_options=extraction)
    return known


def _match(views: Sequence[SourceView], work: Path, effort: Effort) -> None:
    names = [(_name(first), _name(second)) for first, second in neighbours(views)]
    match_pairs(work / "database.db", names, effort)
