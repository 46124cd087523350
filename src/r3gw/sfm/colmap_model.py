"""COLMAP models on disk (.bin or .txt), read by pycolmap: posed pinhole cameras and points."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pycolmap
import torch

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.scene import Points
from r3gw.sfm.binary_check import check_whole

_PINHOLES = ("PINHOLE", "SIMPLE_PINHOLE")
_FILES = ("cameras", "images", "points3D")


@dataclass(frozen=True)
class ColmapModel:
    """Cameras by image name, as written in the model, and the sparse points."""

    cameras: dict[str, Camera]
    points: Points


def read_model(folder: Path) -> ColmapModel:
    """Read the model in ``folder``.

    Raises:
        InputError: If files are missing or damaged, a camera is distorted, a pose is not finite,
            or the model has no images or no points.
    """
    for suffix in (".bin", ".txt"):
        if all((folder / f"{name}{suffix}").is_file() for name in _FILES):
            break
    else:
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
    ordered = [model.points3D[identifier] for identifier in sorted(model.points3D)]
    xyz = np.array([point.xyz for point in ordered], dtype=np.float32)
    rgb = np.array([point.color for point in ordered], dtype=np.uint8)
    if not np.isfinite(xyz).all():
        raise InputError(f"{source}: the model has points at NaN or infinity; run SfM again")
    return ColmapModel(cameras, Points(xyz, rgb))


def _camera(image: pycolmap.Image, source: Path) -> Camera:
    camera = image.camera
    if camera is None:
        raise InputError(f"{source}: {image.name} has no camera; make the model again")
    if camera.model.name not in _PINHOLES:
        raise InputError(
            f"{source}: camera of {image.name} has the model {camera.model.name}, but photos must "
            "be undistorted to PINHOLE; run COLMAP's image_undistorter, or import as 'photos'"
        )
    intrinsics = [*camera.params[:2], *camera.params[2:]]
    if camera.model.name == "SIMPLE_PINHOLE":
        intrinsics = [camera.params[0], *camera.params]
    fx, fy, cx, cy = (float(value) for value in intrinsics)
    cam_from_world = np.eye(4)
    cam_from_world[:3] = image.cam_from_world().matrix()
    values = np.append(cam_from_world.ravel(), (fx, fy, cx, cy))
    if not np.isfinite(values).all() or min(fx, fy) <= 0:
        raise InputError(
            f"{source}: camera of {image.name} is not usable (NaN in its pose, or focal length "
            f"{fx:g} px); remove the image from the model"
        )
    size = (int(camera.width), int(camera.height))
    return Camera(torch.from_numpy(cam_from_world), (fx, fy, cx, cy), *size)
