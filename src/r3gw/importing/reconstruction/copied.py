"""Cameras and points of a pycolmap model, copied: nothing borrowed from it leaves this function."""

from pathlib import Path

import numpy as np
import pycolmap

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.importing.lens import Lens
from r3gw.importing.posed import camera_of
from r3gw.importing.posed_model import PosedModel
from r3gw.importing.source import SourcePoints


def from_reconstruction(model: pycolmap.Reconstruction, source: Path) -> PosedModel:
    """Copy cameras and points out of a pycolmap model; ``source`` is for error messages.

    Raises:
        InputError: If the model has no images or no points, or a value is not finite.
    """
    cameras: dict[str, Camera] = {}
    lenses: dict[str, Lens] = {}
    for image in model.images.values():
        if not image.has_pose:
            continue
        pose = np.eye(4)
        pose[:3] = image.cam_from_world().matrix()
        name, lens = str(image.name), Lens.of(image.camera)
        cameras[name] = camera_of(pose, lens, f"{source}: {name}")
        if not lens.is_pinhole:
            lenses[name] = lens
    if not model.points3D:
        raise InputError(f"{source}: the model has no 3D points; run SfM again")
    ordered = [model.points3D[identifier] for identifier in sorted(model.points3D)]
    xyz = np.array([point.xyz for point in ordered], dtype=np.float64)
    rgb = np.array([point.color for point in ordered], dtype=np.uint8)
    found = PosedModel(cameras, lenses, SourcePoints(xyz, rgb))
    found.require_usable(source)
    return found
