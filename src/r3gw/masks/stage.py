"""The mask stage: both masks of every photo of an imported scene, from wherever they come."""

import logging
import shutil
from pathlib import Path

from tqdm import tqdm

from r3gw.files import write_json
from r3gw.imaging.files import write_image
from r3gw.masks.checks import MaskFacts, check_photo, check_scene, sky_facts
from r3gw.masks.folder import KINDS
from r3gw.masks.settings import MaskSources
from r3gw.masks.sources import MaskReader
from r3gw.scene import load_scene

_LOG = logging.getLogger(__name__)


def make_masks(scene_folder: Path, target: Path, sources: MaskSources) -> None:
    """Write both masks of every view of a scene, and masks.json last.

    Photos and masks are held one at a time.

    Args:
        scene_folder: An imported scene.
        target: Folder to write: is_valid/ and is_sky/ hold one PNG per view, white = True;
            masks.json tells per view where each mask came from, the share it covers and the
            polarity that its shape suggests, and lists all warnings.
        sources: Where masks come from.

    Raises:
        InputError: If a mask is missing from all its sources, unreadable, of another size than
            its photo or certainly wrong (r3gw.masks.checks).
    """
    scene = load_scene(scene_folder)
    (target / "masks.json").unlink(missing_ok=True)
    for kind in KINDS:
        shutil.rmtree(target / kind, ignore_errors=True)
    reader = MaskReader(scene_folder, scene.views, sources)
    sky: dict[str, MaskFacts] = {}
    valid: dict[str, MaskFacts] = {}
    warnings: list[str] = []
    for view in tqdm(scene.views, desc=f"masks of {scene.name}", unit="photo", leave=False):
        sky_from, is_sky = reader.is_sky(view)
        valid_from, is_valid = reader.is_valid(view)
        is_opaque = reader.is_opaque(view)
        is_sky, is_valid = is_sky & is_opaque, is_valid & is_opaque
        sky[view.name] = sky_facts(is_sky, sky_from, reader.levels("is_sky", view, sky_from))
        valid[view.name] = MaskFacts(
            valid_from,
            float(is_valid.mean()),
            transparent=float(1.0 - is_opaque.mean()),
            levels=reader.levels("is_valid", view, valid_from),
        )
        warnings += check_photo(view.name, sky[view.name], valid[view.name])
        for kind, mask in zip(KINDS, (is_valid, is_sky), strict=True):
            write_image(target / kind / f"{view.name}.png", mask)
    warnings += check_scene(sky, valid)
    for warning in warnings:
        _LOG.warning(warning)
    views = {
        name: {"is_sky": facts.as_json(), "is_valid": valid[name].as_json()}
        for name, facts in sky.items()
    }
    record = {"sources": sources.model_dump(mode="json"), "views": views, "warnings": warnings}
    write_json(target / "masks.json", record)
