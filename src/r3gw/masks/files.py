"""The mask folder: is_valid/, is_sky/ and masks.json, white = True; who writes and reads it."""

import logging
import shutil
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from r3gw.files import InputError, write_json
from r3gw.imaging.files import read_rgb, write_image
from r3gw.imaging.masks import read_mask
from r3gw.masks.classical import segment_sky
from r3gw.scene import View, load_scene

SkyPolicy = Literal["given", "classical", "given-or-classical"]
Mask = NDArray[np.bool_]

_LOG = logging.getLogger(__name__)
_KINDS = ("is_valid", "is_sky")


def make_masks(scene_folder: Path, target: Path, *, sky: SkyPolicy) -> None:
    """Write both masks of every view of a scene, and masks.json last.

    Args:
        scene_folder: An imported scene.
        target: Folder to write: is_valid/ and is_sky/ hold one PNG per view, white = True;
            masks.json tells per view where each mask came from and the share it covers.
        sky: ``given`` takes the masks of the dataset and fails where one is missing,
            ``classical`` segments every photo, ``given-or-classical`` only where none is given.
            Without a given occluder mask every pixel is valid.

    Raises:
        InputError: If a mask is unreadable, of another size than its photo, or missing.
    """
    scene = load_scene(scene_folder)
    (target / "masks.json").unlink(missing_ok=True)
    for kind in _KINDS:
        shutil.rmtree(target / kind, ignore_errors=True)
    report = {}
    for view in tqdm(scene.views, desc=f"masks of {scene.name}", unit="photo", leave=False):
        sky_from, is_sky = _sky(scene_folder, view, sky)
        valid_from, is_valid = _valid(scene_folder, view)
        for kind, mask in zip(_KINDS, (is_valid, is_sky), strict=True):
            _warn_if_uniform(view, kind, mask)
            write_image(target / kind / f"{view.name}.png", mask)
        report[view.name] = {
            "is_sky": {"source": sky_from, "share": round(float(is_sky.mean()), 6)},
            "is_valid": {"source": valid_from, "share": round(float(is_valid.mean()), 6)},
        }
    write_json(target / "masks.json", {"sky": sky, "views": report})


def load_masks(folder: Path, view: View) -> tuple[Mask, Mask]:
    """Read ``(is_valid, is_sky)``, each ``[H, W]``, of one view from a mask folder.

    Raises:
        InputError: If a mask is missing or of another size than the view's photo.
    """
    is_valid, is_sky = (
        read_mask(folder / kind / f"{view.name}.png", view.width, view.height) for kind in _KINDS
    )
    return is_valid, is_sky


def _sky(folder: Path, view: View, policy: SkyPolicy) -> tuple[str, Mask]:
    given = folder / "given" / "is_sky" / f"{view.name}.png"
    if policy != "classical" and given.is_file():
        return "given", read_mask(given, view.width, view.height)
    if policy == "given":
        raise InputError(
            f"{given}: the dataset has no sky mask for {view.name}; add it, or set "
            "'sky_masks: given-or-classical' in the scene's entry"
        )
    return "classical", segment_sky(read_rgb(folder / view.image))


def _valid(folder: Path, view: View) -> tuple[str, Mask]:
    given = folder / "given" / "is_valid" / f"{view.name}.png"
    if given.is_file():
        return "given", read_mask(given, view.width, view.height)
    return "all", np.ones((view.height, view.width), dtype=np.bool_)


_MEANING: dict[tuple[str, bool], str] = {
    ("is_sky", True): "all sky; it teaches no building",
    ("is_sky", False): "without any sky",
    ("is_valid", False): "all occluder; it teaches nothing",
}


def _warn_if_uniform(view: View, kind: str, mask: Mask) -> None:
    if mask.all() or not mask.any():
        meaning = _MEANING.get((kind, bool(mask.all())))
        if meaning is not None:
            _LOG.warning("mask %s of %s is %s; look at the photo", kind, view.name, meaning)
