"""The training photos in memory: uint8 pictures and masks, each held once."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Bool, Float, Int8, UInt8
from torch import Tensor

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.imaging.files import read_linear, read_rgb
from r3gw.masks.folder import load_masks
from r3gw.scene import Scene, View
from r3gw.training.known_suns import direction_of
from r3gw.training.visible_sky import VisibleSky, visible_sky


@dataclass(frozen=True)
class Photo:
    """One training photo.

    Attributes:
        name: File stem.
        camera: Its camera.
        planes: Display values, 0 to 255, one plane per channel.
        is_valid: False on occluders.
        is_sky: True on sky.
        seen_sky: Some of its sky pixels; None if it shows hardly any.
        normals: Given unit normals times 127, in world axes, 0 where there is none.
        known_sun: Unit vector to its sun if north were +z, where date, time and place tell it.
    """

    name: str
    camera: Camera
    planes: UInt8[Tensor, "3 h w"]
    is_valid: Bool[Tensor, "h w"]
    is_sky: Bool[Tensor, "h w"]
    seen_sky: VisibleSky | None = None
    known_sun: Float[Tensor, "3"] | None = None
    normals: Int8[Tensor, "h w 3"] | None = None

    def target(self) -> Float[Tensor, "h w 3"]:
        """Display values in [0, 1]."""
        return self.planes.permute(1, 2, 0).float() / 255.0


def read_photo(view: View, scene_folder: Path) -> UInt8[np.ndarray, "h w 3"]:
    """Read the photo of a view, display values.

    Raises:
        InputError: If the file is missing, unreadable or of the wrong size.
    """
    path = scene_folder / view.image
    pixels = read_rgb(path)
    _require_size(path, pixels, view)
    return pixels


def read_normals(view: View, scene_folder: Path) -> Int8[Tensor, "h w 3"] | None:
    """The normal map that came with a view, as `Photo` holds it.

    Raises:
        InputError: If the file is missing, unreadable or of the wrong size.
    """
    if view.normals is None:
        return None
    path = scene_folder / view.normals
    normals = read_linear(path)
    _require_size(path, normals, view)
    return torch.from_numpy(np.round(127 * np.clip(normals, -1, 1)).astype(np.int8))


def _require_size(path: Path, picture: np.ndarray, view: View) -> None:
    height, width = picture.shape[:2]
    if (height, width) != (view.height, view.width):
        raise InputError(
            f"{path}: {width}x{height} px, but scene.json says {view.width}x{view.height} px; "
            "import the scene again"
        )


def load_photos(scene: Scene, scene_folder: Path, masks_folder: Path) -> list[Photo]:
    """Read all training photos of a scene and their masks.

    Raises:
        InputError: If a file is missing or of the wrong size, or there is no training photo.
    """
    photos = []
    for view in scene.split("train"):
        pixels = read_photo(view, scene_folder)
        is_valid, is_sky = map(torch.from_numpy, load_masks(masks_folder, view))
        planes = torch.from_numpy(np.moveaxis(pixels, -1, 0).copy())
        photos.append(
            Photo(
                view.name,
                view.camera,
                planes,
                is_valid,
                is_sky,
                visible_sky(view.camera, planes, is_sky & is_valid),
                None if view.sun is None else direction_of(view.sun),
                read_normals(view, scene_folder),
            )
        )
    if not photos:
        raise InputError(f"{scene_folder / 'scene.json'}: no view has the split 'train'")
    return photos


def camera_extent(cameras: list[Camera]) -> float:
    """1.1 times the largest distance of a camera from the cameras' mean, world units."""
    centres = torch.stack([camera.centre for camera in cameras])
    return 1.1 * float((centres - centres.mean(dim=0)).norm(dim=-1).max())
