"""The import stage: picks the reader of a format, sets the gauge, writes the scene folder."""

from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import numpy as np

from r3gw.files import InputError
from r3gw.scene import Scene
from r3gw.settings import PhotosScene, SceneSettings
from r3gw.sfm.gauge import scene_from_source, upright_rotation
from r3gw.sfm.layout_a import read_layout_a
from r3gw.sfm.photos import undistorted_photos
from r3gw.sfm.source import SourceScene
from r3gw.sfm.write import clear_scene, write_scene


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
    if not source.is_dir():
        raise InputError(f"{source}: no such folder; correct 'path' of scene '{name}'")
    target.mkdir(parents=True, exist_ok=True)
    clear_scene(target)
    with _read(settings, source, target, num_threads, seed) as found:
        rotation = None
        if isinstance(settings, PhotosScene):
            rotations = [view.camera.cam_from_world[:3, :3].numpy() for view in found.views]
            rotation = upright_rotation(np.stack(rotations))
        return write_scene(
            found,
            scene_from_source(found.points, rotation, settings.extent),
            target,
            name=name,
            source_format=settings.format,
            max_image_px=settings.max_image_px,
        )


def _read(
    settings: SceneSettings, source: Path, target: Path, num_threads: int, seed: int
) -> AbstractContextManager[SourceScene]:
    """The source's views, whose files stay readable while the context is open."""
    if isinstance(settings, PhotosScene):
        return undistorted_photos(
            source, target, matching=settings.matching, num_threads=num_threads, seed=seed
        )
    return nullcontext(read_layout_a(source))
