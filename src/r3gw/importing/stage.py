"""The import stage: picks the reader of a format, sets the gauge, writes the scene folder."""

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.importing.completeness import require_complete
from r3gw.importing.formats import reader_of
from r3gw.importing.gauge import scene_from_source, upright_rotation
from r3gw.importing.hold_out import with_held_out
from r3gw.importing.normals import normals_beside, with_normals
from r3gw.importing.precision import require_single_precision
from r3gw.importing.reader import Effort
from r3gw.importing.report import write_report
from r3gw.importing.settings import SceneSettings
from r3gw.importing.source import SourceScene
from r3gw.importing.suns import with_suns
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
            ground_truth/ and sfm_report.json. An earlier import is replaced.
        num_threads: Threads for features and matching.
        seed: Seed of the random sampling inside SfM.

    Raises:
        InputError: If anything in ``source`` is missing or wrong; names it and the remedy.
    """
    require_complete(name, settings, source)
    target.mkdir(parents=True, exist_ok=True)
    clear_scene(target)
    with tempfile.TemporaryDirectory(prefix=".import-", dir=target) as folder:
        read = reader_of(settings, source).read(Effort(Path(folder), num_threads, seed))
        found = with_suns(with_held_out(read, settings, source), settings)
        found = with_normals(found, settings.normals, normals_beside(source))
        similarity = scene_from_source(found.points, _rotation(found), settings.extent)
        require_single_precision(found, similarity, source)
        write_report(found, settings.format, target)
        return write_scene(
            found,
            similarity,
            target,
            name=name,
            source_format=settings.format,
            max_image_px=settings.max_image_px,
        )


def _rotation(found: SourceScene) -> NDArray[np.float64]:
    """How the source's frame is turned, so that up becomes -y."""
    if found.turn is not None:
        return found.turn
    rotations = [view.camera.cam_from_world[:3, :3].numpy() for view in found.views]
    return upright_rotation(np.stack(rotations))
