"""Normal maps that come with photos, from a network or a scan: one more supervision of training.

They lie in ``normals/`` beside the photos, each under its photo's name. An EXR file holds the unit
vectors themselves; in any other picture 0 to the largest value stand for -1 to 1. Where a vector is
far from unit length (black, grey), there is no normal. Their axes are a setting, because files do
not say them: ``opencv`` is a camera's x right, y down, z forward; ``opengl`` its x right, y up, z
backward; ``world`` the axes that the source's cameras are given in.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.imaging.decode import read_picture
from r3gw.imaging.files import read_linear
from r3gw.importing.lens import Lens, undistorted
from r3gw.importing.named_files import files_below, listed, pictures_below
from r3gw.importing.source import Axes, SourceNormals, SourceScene
from r3gw.scene.names import ByPhoto, normalised

FOLDER = "normals"
VECTORS = ".exr"  # suffix of files that hold vectors as they are
LENGTHS = (0.7, 1.3)  # of vectors that count; 8 bits and averages across edges stay within
FEWEST = 0.01  # share of a picture's pixels that must hold a normal
FACING = 0.5  # share of the normals that must be turned to the camera
_OPENGL = np.array([1.0, -1.0, -1.0], np.float32)  # from OpenGL's axes to OpenCV's
_OTHERS = "one of opencv, opengl and world"

Vectors = NDArray[np.float32]


def normals_beside(source: Path) -> Path:
    """The folder of normal maps of a dataset: beside its photos."""
    undistorted_ = source / "undistorted"
    return (undistorted_ if undistorted_.is_dir() else source) / FOLDER


def with_normals(found: SourceScene, axes: Axes, folder: Path) -> SourceScene:
    """The scene with the normal map of each photo that has one, and a note of them.

    Args:
        found: What a reader found.
        axes: Of all maps.
        folder: Of the maps, if there is one.

    Raises:
        InputError: If two maps are for one photo, or one fits several photos.
    """
    if not folder.is_dir():
        return found
    vectors = [path for path in files_below(folder) if path.suffix.lower() == VECTORS]
    files = pictures_below(folder) | {
        normalised(str(path.relative_to(folder))): path for path in vectors
    }
    if not files:
        return found
    maps = ByPhoto(files, [view.path for view in found.views], str(folder))
    views = tuple(
        replace(view, normals=SourceNormals(path, axes))
        if (path := maps.get(view.path)) is not None
        else view
        for view in found.views
    )
    count = sum(view.normals is not None for view in views)
    note = f"{count} of {len(views)} photos have a normal map, read with {axes} axes"
    if maps.unused:
        note += f"; maps that belong to no photo are not used: {listed(maps.unused, 3)}"
    return replace(found, views=views, notes=(*found.notes, note))


def world_normals(
    given: SourceNormals,
    camera: Camera,
    lens: Lens | None,
    size_px: tuple[int, int],
) -> Vectors:
    """Unit normals ``[H, W, 3]`` of a photo as its camera sees it, in the source's world; 0: none.

    Args:
        given: The map's file, and its axes.
        camera: The photo's, without distortion, at full size.
        lens: The distorted camera that took photo and map; None if ``camera`` did.
        size_px: Width and height that the map must have.

    Raises:
        InputError: If the map is unreadable, grey or of another size, holds hardly any unit
            vector, or its vectors are turned away from the camera, as those of other axes are.
    """
    vectors = _vectors(given.path)
    if vectors.shape[:2] != size_px[::-1]:
        raise InputError(
            f"{given.path}: the normal map is {vectors.shape[1]}x{vectors.shape[0]} px but its "
            f"photo is {size_px[0]}x{size_px[1]} px; make it again at the photo's size"
        )
    if lens is not None:
        bytes_ = np.round(127.5 * (np.clip(vectors, -1, 1) + 1)).astype(np.uint8)
        vectors = undistorted(bytes_, lens).astype(np.float32) / 127.5 - 1
    normals = _unit(vectors)
    is_given = np.linalg.norm(normals, axis=-1) > 0
    if is_given.mean() < FEWEST:
        raise InputError(
            f"{given.path}: holds hardly any unit vector; write normals as EXR, or as (n + 1) / 2 "
            "times the largest value of a PNG"
        )
    world_from_cam = camera.cam_from_world[:3, :3].T.numpy().astype(np.float32)
    if given.axes == "opengl":
        normals = normals * _OPENGL
    if given.axes != "world":
        normals = normals @ world_from_cam.T
    looks = pixel_rays(camera).numpy() @ world_from_cam.T
    facing = float(((normals * looks).sum(-1)[is_given] < 0).mean())
    if facing < FACING:
        raise InputError(
            f"{given.path}: with {given.axes} axes only {100 * facing:.0f} % of its normals face "
            f"the camera; give the entry's 'normals' the axes that the maps have, {_OTHERS}"
        )
    return normals


def smaller_normals(normals: Vectors, width: int, height: int) -> Vectors:
    """Normals ``[height, width, 3]`` of a picture made smaller: whole pixels, nothing mixed."""
    rows = ((np.arange(height) + 0.5) * normals.shape[0] / height).astype(int)
    columns = ((np.arange(width) + 0.5) * normals.shape[1] / width).astype(int)
    return np.ascontiguousarray(normals[rows][:, columns])


def _vectors(path: Path) -> Vectors:
    if path.suffix.lower() == VECTORS:
        return read_linear(path)
    pixels = read_picture(path).pixels
    if pixels.ndim != 3:
        raise InputError(f"{path}: is grey, but a normal map has three channels, x, y and z")
    largest = np.float32(np.iinfo(pixels.dtype).max)
    return np.asarray(pixels, np.float32) * (2 / largest) - 1


def _unit(vectors: Vectors) -> Vectors:
    """Vectors of length 1, and 0 where they are no normals."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    is_one = (length > LENGTHS[0]) & (length < LENGTHS[1])
    return np.where(is_one, vectors / np.maximum(length, 1e-6), 0.0).astype(np.float32)
