"""Label maps: which pixels of a picture of classes (colours or ids) are sky and which occluder.

Cityscapes' table of classes (cityscapesScripts, labels.py) gives colours, ids and train ids; the
label maps of the original NeRF-OSR scenes are in its colours. Vegetation is part of the scene.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.files import read_labels
from r3gw.masks.settings import LabelClasses

Mask = NDArray[np.bool_]
Classes = Literal["cityscapes-colours", "cityscapes-ids", "cityscapes-train-ids"] | LabelClasses


@dataclass(frozen=True)
class _Class:
    """One class of Cityscapes; 255 as train id means that it has none."""

    colour: tuple[int, int, int]
    number: int
    train_number: int


_CLASSES = {
    "unlabeled": _Class((0, 0, 0), 0, 255),
    "dynamic": _Class((111, 74, 0), 5, 255),
    "ground": _Class((81, 0, 81), 6, 255),
    "road": _Class((128, 64, 128), 7, 0),
    "sidewalk": _Class((244, 35, 232), 8, 1),
    "parking": _Class((250, 170, 160), 9, 255),
    "rail track": _Class((230, 150, 140), 10, 255),
    "building": _Class((70, 70, 70), 11, 2),
    "wall": _Class((102, 102, 156), 12, 3),
    "fence": _Class((190, 153, 153), 13, 4),
    "guard rail": _Class((180, 165, 180), 14, 255),
    "bridge": _Class((150, 100, 100), 15, 255),
    "tunnel": _Class((150, 120, 90), 16, 255),
    "pole": _Class((153, 153, 153), 17, 5),
    "traffic light": _Class((250, 170, 30), 19, 6),
    "traffic sign": _Class((220, 220, 0), 20, 7),
    "vegetation": _Class((107, 142, 35), 21, 8),
    "terrain": _Class((152, 251, 152), 22, 9),
    "sky": _Class((70, 130, 180), 23, 10),
    "person": _Class((220, 20, 60), 24, 11),
    "rider": _Class((255, 0, 0), 25, 12),
    "car": _Class((0, 0, 142), 26, 13),
    "truck": _Class((0, 0, 70), 27, 14),
    "bus": _Class((0, 60, 100), 28, 15),
    "caravan": _Class((0, 0, 90), 29, 255),
    "trailer": _Class((0, 0, 110), 30, 255),
    "train": _Class((0, 80, 100), 31, 16),
    "motorcycle": _Class((0, 0, 230), 32, 17),
    "bicycle": _Class((119, 11, 32), 33, 18),
}
_OCCLUDERS = ("person", "rider", "car", "truck", "bus", "train", "motorcycle", "bicycle")
_KNOWN_SHARE = 0.95  # of the pixels that must have a colour of the table


def read_label_masks(path: Path, classes: Classes, width: int, height: int) -> tuple[Mask, Mask]:
    """Read a label map as ``(is_valid, is_sky)``, each ``[height, width]``.

    Args:
        path: RGB picture of colours or grey picture of ids.
        classes: How it is to be read.
        width, height: Size of the photo, px; a larger map of the same shape is scaled down.

    Raises:
        InputError: If it is unreadable, of another shape than the photo, or of another kind
            than ``classes``.
    """
    labels = read_labels(path)
    shape = labels.shape[:2]
    if abs(shape[1] * height / (shape[0] * width) - 1.0) > 0.02 or shape[0] < height:
        raise InputError(
            f"{path}: the label map is {shape[1]}x{shape[0]} px but its photo is "
            f"{width}x{height} px; make the label map at the photo's size"
        )
    if shape != (height, width):
        nearest = cv2.INTER_NEAREST_EXACT
        labels = cv2.resize(labels, (width, height), interpolation=nearest).astype(np.uint8)
    if classes == "cityscapes-colours":
        return _from_colours(path, labels)
    return _from_ids(path, labels, _class_ids(classes))


def _class_ids(classes: Classes) -> LabelClasses:
    if isinstance(classes, LabelClasses):
        return classes
    numbers = {
        name: entry.number if classes == "cityscapes-ids" else entry.train_number
        for name, entry in _CLASSES.items()
    }
    return LabelClasses(sky=(numbers["sky"],), occluders=tuple(numbers[n] for n in _OCCLUDERS))


def _from_colours(path: Path, labels: NDArray[np.uint8]) -> tuple[Mask, Mask]:
    if labels.ndim == 2:
        raise InputError(
            f"{path}: a label map of ids, not of Cityscapes colours; set 'label_classes' to "
            "cityscapes-ids, cityscapes-train-ids, or the ids of sky and occluders"
        )
    codes = _codes(labels)
    by_name = {name: _codes(np.array(entry.colour)) for name, entry in _CLASSES.items()}
    known = float(np.isin(codes, list(by_name.values())).mean())
    if known < _KNOWN_SHARE:
        raise InputError(
            f"{path}: only {known:.0%} of the pixels have a colour of Cityscapes; save label maps "
            "without loss (PNG), or give maps of ids and 'label_classes'"
        )
    is_occluder = np.isin(codes, [by_name[name] for name in _OCCLUDERS])
    return ~is_occluder, np.asarray(codes == by_name["sky"])


def _codes(colours: NDArray[np.integer]) -> NDArray[np.int64]:
    """One number per colour ``[..., 3]``."""
    weights = np.array([65536, 256, 1], np.int64)
    return np.asarray((colours.astype(np.int64) * weights).sum(axis=-1))


def _from_ids(path: Path, labels: NDArray[np.uint8], classes: LabelClasses) -> tuple[Mask, Mask]:
    if labels.ndim == 3:
        if (labels != labels[..., :1]).any():
            raise InputError(
                f"{path}: a label map of colours, not of ids; set 'label_classes' to "
                "cityscapes-colours, or save the ids as a grey picture"
            )
        labels = labels[..., 0]
    return ~np.isin(labels, classes.occluders), np.isin(labels, classes.sky)
