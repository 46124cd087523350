"""The import stage: picks the reader of a format, sets the gauge, writes the scene folder."""

from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.importing.completeness import require_complete
from r3gw.importing.gauge import scene_from_source, upright_rotation
from r3gw.importing.readers.colmap import read_colmap_folder
from r3gw.importing.readers.nerf_osr import read_layout_a
from r3gw.importing.readers.nerf_osr_original import read_nerf_osr_original
from r3gw.importing.readers.nerfstudio import UPRIGHT_FROM_Z_UP, read_nerfstudio
from r3gw.importing.reconstruction.photos import registered_photos
from r3gw.importing.settings import (
    ColmapScene,
    NerfOsrOriginalScene,
    NerfOsrScene,
    NerfstudioScene,
    PhotosScene,
    SceneSettings,
    SyntheticScene,
)
from r3gw.importing.source import SourceScene
from r3gw.importing.write import clear_scene, write_scene
from r3gw.scene import Scene


def import_scene(
    name: str,
    settings: SceneSettings,
    source: Path,
    target: Path,
    *,
    num_threads: int,
    seed: int = 0,
) -> Scene:
    """Turn a dataset or a folder of photos into the scene folder ``target``.

    Args:
        name: The scene's name in the configuration.
        settings: Its entry there.
        source: Folder of the dataset or of the photos.
        target: Folder to write: scene.json (last), images/, points.npz, given/, envmaps/,
            ground_truth/ and, for photos, sfm_report.json. An earlier import is replaced.
        num_threads: Threads for features and matching.
        seed: For the random sampling inside SfM.

    Raises:
        InputError: If anything in ``source`` is missing or wrong; names it and the remedy.
    """
    require_complete(name, settings, source)
    target.mkdir(parents=True, exist_ok=True)
    clear_scene(target)
    with _read(settings, source, target, num_threads, seed) as found:
        return write_scene(
            found,
            scene_from_source(found.points, _rotation(settings, found), settings.extent),
            target,
            name=name,
            source_format=settings.format,
            max_image_px=settings.max_image_px,
        )


def _rotation(settings: SceneSettings, found: SourceScene) -> NDArray[np.float64] | None:
    """How the source's frame is turned, so that up becomes -y; None leaves it as it is."""
    if isinstance(settings, SyntheticScene | NerfOsrScene):
        return None
    if not isinstance(settings, PhotosScene) and settings.up == "given":
        return UPRIGHT_FROM_Z_UP if isinstance(settings, NerfstudioScene) else None
    rotations = [view.camera.cam_from_world[:3, :3].numpy() for view in found.views]
    return upright_rotation(np.stack(rotations))


def _read(
    settings: SceneSettings, source: Path, target: Path, num_threads: int, seed: int
) -> AbstractContextManager[SourceScene]:
    """The source's views, whose files stay readable while the context is open."""
    if isinstance(settings, PhotosScene):
        return registered_photos(source, target, settings, num_threads=num_threads, seed=seed)
    if isinstance(settings, ColmapScene):
        return nullcontext(read_colmap_folder(source))
    if isinstance(settings, NerfstudioScene):
        return nullcontext(read_nerfstudio(source, num_threads=num_threads, seed=seed))
    if isinstance(settings, NerfOsrOriginalScene):
        return nullcontext(read_nerf_osr_original(source, num_threads=num_threads, seed=seed))
    return nullcontext(read_layout_a(source))
