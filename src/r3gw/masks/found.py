"""Occluders that a training found: is_occluder/ beside its model holds one PNG per photo."""

import shutil
from collections.abc import Mapping
from pathlib import Path

from r3gw.imaging.files import write_image
from r3gw.imaging.masks import read_mask
from r3gw.masks.folder import Mask
from r3gw.scene import View

FOLDER = "is_occluder"


def save_found(run: Path, masks: Mapping[str, Mask]) -> None:
    """Write the masks of a run, white = occluder; those of an earlier one go.

    Args:
        run: Folder of the run.
        masks: ``[H, W]`` by the photos' names; none at all leaves no folder.
    """
    shutil.rmtree(run / FOLDER, ignore_errors=True)
    for name, mask in masks.items():
        write_image(run / FOLDER / f"{name}.png", mask)


def load_found(run: Path, view: View) -> Mask | None:
    """The mask ``[H, W]`` of a photo, True on occluders; None if the run looked for none in it.

    Raises:
        InputError: If the mask is of another size than the photo.
    """
    path = run / FOLDER / f"{view.name}.png"
    return read_mask(path, view.width, view.height) if path.is_file() else None
