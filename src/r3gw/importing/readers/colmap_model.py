"""COLMAP models on disk (.bin or .txt), read by pycolmap: posed cameras and points."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pycolmap

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.importing.lens import is_pinhole
from r3gw.importing.posed import camera_without_lens
from r3gw.importing.readers.binary_check import check_whole
from r3gw.scene import Points

MODEL_FILES = ("cameras", "images", "points3D")


@dataclass(frozen=True)
class ColmapModel:
    """What a model holds.

    Attributes:
        cameras: Pinhole cameras by image name, as written in the model.
        lenses: The distorted camera of every image that has one.
        points: The sparse points.
    """

    cameras: dict[str, Camera]
    lenses: dict[str, pycolmap.Camera]
    points: Points

    def require_pinhole(self, source: Path) -> None:
        """Refuse distorted cameras.

        Raises:
            InputError: Naming an image, its camera's model and the remedy.
        """
        for name, lens in self.lenses.items():
            raise InputError(
                f"{source}: camera of {name} has the model {lens.model.name}, but photos must be "
                "undistorted to PINHOLE; run COLMAP's image_undistorter, or import the folder as "
                "'colmap', which undistorts"
            )


def read_model(folder: Path) -> ColmapModel:
    """Read the model in ``folder``.

    Raises:
        InputError: If files are missing or damaged, a pose is not finite, or the model has no
            images or no points.
    """
    suffix = model_suffix(folder)
    if suffix is None:
        raise InputError(
            f"{folder}: no COLMAP model; it must hold cameras, images and points3D, "
            "all as .bin or all as .txt"
        )
    if suffix == ".bin":
        check_whole(folder)
    model = pycolmap.Reconstruction()
    try:
        (model.read_binary if suffix == ".bin" else model.read_text)(folder)
    except (ValueError, RuntimeError, IndexError) as error:
        reason = " ".join(str(error).split())
        raise InputError(
            f"{folder}: the COLMAP model ({suffix}) is damaged; copy or make it again ({reason})"
        ) from None
    return from_reconstruction(model, folder)


def model_suffix(folder: Path) -> str | None:
    """``.bin`` or ``.txt``, whichever is complete in ``folder``, or None."""
    for suffix in (".bin", ".txt"):
        if all((folder / f"{name}{suffix}").is_file() for name in MODEL_FILES):
            return suffix
    return None


def from_reconstruction(model: pycolmap.Reconstruction, source: Path) -> ColmapModel:
    """Take cameras and points out of a pycolmap model; ``source`` is for error messages.

    Raises:
        InputError: As `read_model`.
    """
    posed = [image for image in model.images.values() if image.has_pose]
    if not posed:
        raise InputError(f"{source}: the model has no images with a pose; run SfM again")
    if not model.points3D:
        raise InputError(f"{source}: the model has no 3D points; run SfM again")
    cameras = {image.name: _camera(image, source) for image in posed}
    lenses = {image.name: image.camera for image in posed if not is_pinhole(image.camera)}
    ordered = [model.points3D[identifier] for identifier in sorted(model.points3D)]
    xyz = np.array([point.xyz for point in ordered], dtype=np.float32)
    rgb = np.array([point.color for point in ordered], dtype=np.uint8)
    if not np.isfinite(xyz).all():
        raise InputError(f"{source}: the model has points at NaN or infinity; run SfM again")
    return ColmapModel(cameras, lenses, Points(xyz, rgb))


def _camera(image: pycolmap.Image, source: Path) -> Camera:
    if image.camera is None:
        raise InputError(f"{source}: {image.name} has no camera; make the model again")
    pose = np.eye(4)
    pose[:3] = image.cam_from_world().matrix()
    return camera_without_lens(pose, image.camera, f"{source}: {image.name}")
