"""Finds rendered pictures and their photos in folders as other programs write them.

* ``<any>/ours_<iteration>/renders/00000.png`` of 3DGS and what is built on it, such as LumiGauss;
  the photos are in ``gt/`` beside.
* ``<any>/rgb/<photo>`` of nerfstudio's ``ns-render dataset``; the photos are in ``gt-rgb/`` beside.
* ``renders/val_step<step>_0000.png`` of gsplat's ``simple_trainer.py``, and ``eval_img_0000.png``
  of nerfstudio's ``ns-eval --render-output-path``; the photo is the left half of each.
* Pictures of any name, with photos of the same names elsewhere.

Of several iterations the last is taken; of `train` and `test`, `test`.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import UInt8

from r3gw.files import InputError
from r3gw.imaging.files import LDR_SUFFIXES, read_rgb

_SIDE_BY_SIDE = re.compile(r"(?:val_step(?P<step>\d+)_|eval_img_)(?P<index>\d+)")
# Folder of renders, and the folder of their photos beside it.
_BESIDE = {"renders": "gt", "rgb": "gt-rgb"}


@dataclass(frozen=True)
class Picture:
    """A picture file, or the left or right half of one.

    Attributes:
        path: The file.
        half: 0 or 1 for the left or the right half; None for all of it.
    """

    path: Path
    half: int | None = None

    def read(self) -> UInt8[np.ndarray, "h w 3"]:
        """The picture's pixels.

        Raises:
            InputError: If the file is no picture, or cannot be halved.
        """
        pixels = read_rgb(self.path)
        if self.half is None:
            return pixels
        width = pixels.shape[1]
        if width % 2:
            raise InputError(
                f"{self.path}: is {width} px wide, but should hold a photo and a render side by "
                "side; rename it if it is one picture"
            )
        return pixels[:, self.half * width // 2 : (self.half + 1) * width // 2]


@dataclass(frozen=True)
class Rendered:
    """What a folder of renders holds, by the renders' names.

    Attributes:
        renders: The renders.
        photos: The photos that the program wrote beside them; None if it wrote none.
    """

    renders: dict[str, Picture]
    photos: dict[str, Picture] | None


def find_rendered(folder: Path) -> Rendered:
    """Look through a program's output for the renders to score.

    Args:
        folder: Holds pictures, or any layout of the list above at most two folders deeper.

    Raises:
        InputError: If there are none, or two of the same name.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; name one that holds pictures")
    for place in _places(folder):
        if found := _side_by_side(place):
            return found
        if place == folder and _pictures(folder) and folder.name not in _BESIDE:
            break
        beside = _BESIDE.get(place.name)
        if beside is not None and _pictures(place):
            photos = place.parent / beside
            return Rendered(
                pictures_by_name(place), pictures_by_name(photos) if photos.is_dir() else None
            )
    return Rendered(pictures_by_name(folder), None)


def pictures_by_name(folder: Path) -> dict[str, Picture]:
    """The pictures of a folder by their stems, in order of their names.

    Raises:
        InputError: If the folder holds none, or two of the same stem.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; name one that holds pictures")
    found: dict[str, Picture] = {}
    for path in _pictures(folder):
        if path.stem in found:
            raise InputError(
                f"{folder}: holds both {found[path.stem].path.name} and {path.name}; keep one"
            )
        found[path.stem] = Picture(path)
    if not found:
        raise InputError(f"{folder}: holds no picture ({', '.join(LDR_SUFFIXES)})")
    return found


def paired(
    names: Iterable[str], others: dict[str, Picture], folder: Path, kind: str
) -> dict[str, Picture]:
    """For every name its partner of the same name; or, where no name fits, in their order.

    Programs that number their renders count photos in the order of their names.

    Args:
        names: Of the renders, in order.
        others: What to pair with.
        folder: Where that lies, for errors.
        kind: What it is, for errors: "photo" or "mask".

    Raises:
        InputError: If only some names fit, or none and the numbers differ.
    """
    names = list(names)
    missing = [name for name in names if name not in others]
    if not missing:
        return {name: others[name] for name in names}
    if len(missing) < len(names) or not all(name.isdigit() for name in names):
        raise InputError(f"{folder}: holds no {kind} named {missing[0]}, as the renders need")
    if len(others) != len(names):
        raise InputError(
            f"{folder}: holds {len(others)} {kind}s for {len(names)} renders that are only "
            f"numbered; leave the {kind}s of those alone, or give the renders their names"
        )
    return dict(zip(names, others.values(), strict=True))


def _places(folder: Path) -> list[Path]:
    """The folder, and those in it down to two levels: the test set first, then the last step."""
    found = [folder, *_subfolders(folder)]
    found += [deeper for each in found[1:] for deeper in _subfolders(each)]
    found += [deeper for each in found if _iteration(each) >= 0 for deeper in _subfolders(each)]
    return sorted(dict.fromkeys(found), key=lambda path: _preference(path, folder))


def _preference(path: Path, folder: Path) -> tuple[bool, int, int]:
    """What is taken first: nothing of the training set, then late iterations, then near ones."""
    parts = path.relative_to(folder).parts
    iteration = max((_iteration(each) for each in (path, path.parent)), default=-1)
    return "train" in parts, -iteration, len(parts)


def _subfolders(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.is_dir())


def _iteration(folder: Path) -> int:
    """The number of a folder ``ours_<iteration>``; -1 for others."""
    found = re.fullmatch(r"ours_(\d+)", folder.name)
    return int(found[1]) if found else -1


def _pictures(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in LDR_SUFFIXES)


def _side_by_side(folder: Path) -> Rendered | None:
    """Photos and renders that share a picture each, of the last step; None if there are none."""
    found = [
        (int(match["step"] or 0), match["index"], path)
        for path in _pictures(folder)
        if (match := _SIDE_BY_SIDE.fullmatch(path.stem))
    ]
    if not found:
        return None
    last = max(step for step, _, _ in found)
    kept = {index: path for step, index, path in found if step == last}
    return Rendered(
        {index: Picture(path, 1) for index, path in kept.items()},
        {index: Picture(path, 0) for index, path in kept.items()},
    )
