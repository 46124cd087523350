"""COLMAP models on disk, in either form, as posed cameras and points."""

from pathlib import Path

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.importing.lens import Lens
from r3gw.importing.posed import camera_of, pose_from_quaternion
from r3gw.importing.posed_model import PosedModel
from r3gw.importing.readers import colmap_binary, colmap_text
from r3gw.importing.readers.colmap_records import StoredModel
from r3gw.importing.source import SourcePoints

MODEL_FILES = ("cameras", "images", "points3D")


def model_suffix(folder: Path) -> str | None:
    """``.bin`` or ``.txt``, whichever is complete in ``folder``, or None."""
    for suffix in (".bin", ".txt"):
        if all((folder / f"{name}{suffix}").is_file() for name in MODEL_FILES):
            return suffix
    return None


def read_model(folder: Path) -> PosedModel:
    """Read the model in ``folder``.

    Raises:
        InputError: If files are missing or damaged, a pose or a camera is none, two images share
            a name, or the model has no images.
    """
    suffix = model_suffix(folder)
    if suffix is None:
        raise InputError(
            f"{folder}: no COLMAP model; it must hold cameras, images and points3D, "
            "all as .bin or all as .txt"
        )
    read = colmap_binary.read_binary if suffix == ".bin" else colmap_text.read_text
    return _checked(read(folder), folder)


def _checked(stored: StoredModel, source: Path) -> PosedModel:
    cameras: dict[str, Camera] = {}
    lenses: dict[str, Lens] = {}
    for image in stored.images:
        where = f"{source}: {image.name}"
        if image.name in cameras:
            raise InputError(f"{where}: is in the model twice; make the model again")
        lens = stored.lenses.get(image.camera_id)
        if lens is None:
            raise InputError(
                f"{where}: its camera {image.camera_id} is not in the model; make the model again"
            )
        pose = pose_from_quaternion(image.quaternion, image.translation, where)
        cameras[image.name] = camera_of(pose, lens, where)
        if not lens.is_pinhole:
            lenses[image.name] = lens
    found = PosedModel(cameras, lenses, SourcePoints(stored.xyz, stored.rgb))
    found.require_usable(source)
    return found
