"""The mask folder: is_valid/, is_sky/ and masks.json, white = True; who writes and reads it."""

import logging
import shutil
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from r3gw.files import write_json
from r3gw.imaging.files import write_image
from r3gw.imaging.masks import read_mask
from r3gw.masks.checks import MaskFacts, check_photo, check_scene, sky_facts
from r3gw.masks.settings import MaskSources
from r3gw.masks.sources import MaskReader
from r3gw.scene import View, load_scene

Mask = NDArray[np.bool_]

_LOG = logging.getLogger(__name__)
_KINDS = ("is_valid", "is_sky")


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
    for kind in _KINDS:
        shutil.rmtree(target / kind, ignore_errors=True)
    reader = MaskReader(scene_folder, sources)
    sky: dict[str, MaskFacts] = {}
    valid: dict[str, MaskFacts] = {}
    warnings: list[str] = []
    for view in tqdm(scene.views, desc=f"masks of {scene.name}", unit="photo", leave=False):
        sky_from, is_sky = reader.is_sky(view)
        valid_from, is_valid = reader.is_valid(view)
        sky[view.name] = sky_facts(is_sky, sky_from)
        valid[view.name] = MaskFacts(valid_from, float(is_valid.mean()))
        warnings += check_photo(view.name, sky[view.name], valid[view.name])
        for kind, mask in zip(_KINDS, (is_valid, is_sky), strict=True):
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


def load_masks(folder: Path, view: View) -> tuple[Mask, Mask]:
    """Read ``(is_valid, is_sky)``, each ``[H, W]``, of one view from a mask folder.

    Raises:
        InputError: If a mask is missing or of another size than the view's photo.
    """
    is_valid, is_sky = (
        read_mask(folder / kind / f"{view.name}.png", view.width, view.height) for kind in _KINDS
    )
    return is_valid, is_sky
