"""Writes the scene folder: pictures scaled, given masks in our polarity, scene.json last."""

import logging
import shutil
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from tqdm import tqdm

from r3gw.files import InputError, atomic_path, write_bytes
from r3gw.geometry.cameras import Camera
from r3gw.geometry.similarity import Similarity
from r3gw.imaging.decode import read_opaque
from r3gw.imaging.files import read_labels, read_linear, write_exr, write_image
from r3gw.imaging.masks import read_mask_levels, resize_mask
from r3gw.importing.lens import undistorted, undistorted_mask
from r3gw.importing.normals import smaller_normals, world_normals
from r3gw.importing.source import SourceMask, SourceScene, SourceView
from r3gw.importing.stored import stored_photo, stored_size
from r3gw.scene import (
    EvaluationEntry,
    Gauge,
    GroundTruth,
    Points,
    Scene,
    View,
    save_points,
    save_scene,
)
from r3gw.scene.names import view_names

_LOG = logging.getLogger(__name__)
_FOLDERS = ("images", "given", "envmaps", "ground_truth")
_FILES = ("scene.json", "points.npz", "sfm_report.json")


def clear_scene(target: Path) -> None:
    """Remove what an earlier import left in ``target``; scene.json goes first."""
    for name in _FILES:
        (target / name).unlink(missing_ok=True)
    for name in _FOLDERS:
        shutil.rmtree(target / name, ignore_errors=True)


def write_scene(
    source: SourceScene,
    similarity: Similarity,
    target: Path,
    *,
    name: str,
    source_format: str,
    max_image_px: int,
) -> Scene:
    """Write ``source`` to the empty folder ``target`` and return the scene.

    Args:
        source: What a reader found.
        similarity: ``scene_from_source``. Ground truth is carried along by its scale only, so
            with ground truth it must not turn.
        target: The scene folder.
        name: The scene's name.
        source_format: Format of its entry in the configuration.
        max_image_px: Photos wider than this are scaled down to this width, by area.

    Raises:
        InputError: If a photo or mask is unreadable or not of its camera's size.
    """
    names = view_names([view.path for view in source.views])
    views = [
        _write_view(view, names[view.path], similarity, target, max_image_px)
        for view in tqdm(source.views, desc=f"importing {name}", unit="photo", leave=False)
    ]
    save_points(Points(_moved(source.points.xyz, similarity), source.points.rgb), target)
    scene = Scene(
        name=name,
        source_format=source_format,
        views=tuple(sorted(views, key=lambda view: view.name)),
        scene_from_source=Gauge.of(similarity),
    )
    save_scene(scene, target)
    counts = len(scene.split("train")), len(scene.split("test")), len(source.points.xyz)
    _LOG.info("%s: %d training views, %d test views, %d points", name, *counts)
    return scene


def _moved(xyz: NDArray[np.float64], similarity: Similarity) -> NDArray[np.float32]:
    """Points in the scene; single precision suffices once they are centred."""
    return similarity.points(torch.from_numpy(xyz)).numpy().astype(np.float32)


def _write_view(
    source: SourceView, name: str, similarity: Similarity, target: Path, max_image_px: int
) -> View:
    full = source.camera
    factor = min(1.0, max_image_px / full.width)
    width, height = (max(1, round(side * factor)) for side in (full.width, full.height))
    camera = full.scaled(width, height)
    cam_from_world: Any = similarity.camera(full.cam_from_world).tolist()
    image = f"images/{name}.png"
    write_image(target / image, _scaled(_photo(source), camera, cv2.INTER_AREA))
    _write_opaque(source, camera, target / "given" / "is_opaque" / f"{name}.png")
    for kind, mask in source.masks.items():
        _write_mask(mask, source, camera, target / "given" / kind / f"{name}.png")
    if source.labels is not None:
        _write_labels(source.labels, source, camera, target / "given" / "labels" / f"{name}.png")
    return View(
        name=name,
        path=source.path,
        image=image,
        width=width,
        height=height,
        source_size_px=None if factor == 1.0 else (full.width, full.height),
        intrinsics=camera.intrinsics,
        cam_from_world=cam_from_world,
        split=source.split,
        session=source.session,
        sun=source.sun,
        normals=_write_normals(source, name, camera, similarity, target),
        evaluation=_copied_evaluation(source, name, camera, target),
        truth=_copied_truth(source, name, camera, similarity.scale, target),
    )


def _scaled(pixels: NDArray[Any], camera: Camera, interpolation: int) -> NDArray[Any]:
    if pixels.shape[:2] == (camera.height, camera.width):
        return pixels
    size = (camera.width, camera.height)
    return cv2.resize(pixels, size, interpolation=interpolation)


def _photo(source: SourceView) -> NDArray[np.uint8]:
    """The photo as ``source.camera`` sees it."""
    photo = stored_photo(source)
    return photo if source.lens is None else undistorted(photo, source.lens)


def _write_mask(mask: SourceMask, source: SourceView, camera: Camera, path: Path) -> None:
    read = read_mask_levels(mask.path, *stored_size(source))
    values = read.is_white if mask.white_means else ~read.is_white
    _write_fitted(values, source, camera, path)
    if values.all() or not values.any():
        # The mask stage sees black and white alone, but may have to say what is wrong with it.
        write_bytes(path.with_suffix(".txt"), (mask.levels or read.described()).encode())


def _write_opaque(source: SourceView, camera: Camera, path: Path) -> None:
    """Keep where the photo is opaque, if it is not everywhere."""
    is_opaque = read_opaque(source.photo)
    if is_opaque is not None:
        _write_fitted(is_opaque, source, camera, path)


def _write_fitted(mask: NDArray[np.bool_], source: SourceView, camera: Camera, path: Path) -> None:
    """Write a mask of the stored photo as one of the imported photo."""
    if source.lens is not None:
        mask = undistorted_mask(mask, source.lens)
    write_image(path, resize_mask(mask, camera.width, camera.height))


def _write_labels(file: Path, source: SourceView, camera: Camera, path: Path) -> None:
    """Copy a label map; where it must shrink, whole pixels are taken: classes do not mix."""
    labels = read_labels(file)
    width, height = stored_size(source)
    if labels.shape[:2] != (height, width):
        raise InputError(
            f"{file}: the label map is {labels.shape[1]}x{labels.shape[0]} px but its photo is "
            f"{width}x{height} px; make the labels again at the photo's size"
        )
    scaled = _scaled(labels, camera, cv2.INTER_NEAREST_EXACT)
    write_image(path, scaled)


def _write_normals(
    source: SourceView, name: str, camera: Camera, similarity: Similarity, target: Path
) -> str | None:
    if source.normals is None:
        return None
    given = world_normals(source.normals, source.camera, source.lens, stored_size(source))
    turned = given @ similarity.rotation.numpy().astype(np.float32).T
    path = f"given/normals/{name}.exr"
    write_exr(target / path, smaller_normals(turned, camera.width, camera.height))
    return path


def _copied_evaluation(
    source: SourceView, name: str, camera: Camera, target: Path
) -> EvaluationEntry | None:
    entry = source.evaluation
    if entry is None:
        return None
    mask = None
    if entry.mask is not None:
        mask = f"given/eval/{name}.png"
        _write_mask(SourceMask(Path(entry.mask)), source, camera, target / mask)
    original = Path(entry.env_map)
    env_map = f"envmaps/{original.parent.name}/{original.name}"
    _copy(original, target / env_map)
    return entry.model_copy(update={"mask": mask, "env_map": env_map})


def _copied_truth(
    source: SourceView, name: str, camera: Camera, scale: float, target: Path
) -> GroundTruth | None:
    truth = source.truth
    if truth is None:
        return None
    paths = {kind: f"ground_truth/{kind}/{name}.exr" for kind in ("albedo", "normal")}
    paths["depth"] = f"ground_truth/depth/{name}.exr"
    paths["env_map"] = f"ground_truth/envmaps/{Path(truth.env_map).name}"
    _copy(Path(truth.env_map), target / paths["env_map"])
    for kind in ("albedo", "normal", "depth"):
        pixels = read_linear(Path(getattr(truth, kind)))
        # Neither normals nor depths may be averaged across an edge.
        filter_ = cv2.INTER_AREA if kind == "albedo" else cv2.INTER_NEAREST
        factor = scale if kind == "depth" else 1.0
        write_exr(target / paths[kind], _scaled(pixels, camera, filter_) * np.float32(factor))
    return truth.model_copy(update=paths)


def _copy(source: Path, target: Path) -> None:
    if not source.is_file():
        raise InputError(f"{source}: no such file, but the scene's lists name it")
    with atomic_path(target) as path:
        shutil.copyfile(source, path)
