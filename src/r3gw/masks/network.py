"""Masks from an ONNX segmentation network that the user names, run by OpenCV's dnn.

The network gets one photo at a time as float32 ``[1, 3, h, w]`` (RGB, normalised) and answers
with scores ``[1, classes, h', w']`` or with class ids ``[1, h', w']`` or ``[1, 1, h', w']``.
"""

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.masks.settings import NetworkSettings

_CHILD = """
import sys
import cv2, numpy as np
net = cv2.dnn.readNetFromONNX(sys.argv[1])
net.setInput(np.zeros((1, 3, int(sys.argv[2]), int(sys.argv[3])), np.float32))
net.forward()
"""

Rgb = NDArray[np.uint8]
Mask = NDArray[np.bool_]


class SegmentationNetwork:
    """A network that was read once; call it per photo."""

    def __init__(self, settings: NetworkSettings) -> None:
        """Read the network.

        Raises:
            InputError: If the file is missing or OpenCV cannot read it.
        """
        self._settings = settings
        self._path = Path(settings.model)
        if not self._path.is_file():
            raise InputError(f"{self._path}: no such network; correct 'network: model'")
        _try_in_child(self._path, settings)
        try:
            self._net = cv2.dnn.readNetFromONNX(str(self._path))
        except cv2.error as error:
            raise InputError(
                f"{self._path}: OpenCV cannot read this network ({_reason(error)}); export it to "
                "ONNX with a common opset such as 13"
            ) from None

    def __call__(self, photo: Rgb) -> tuple[Mask, Mask]:
        """Segment a photo ``[H, W, 3]``; ``(is_valid, is_sky)``, each ``[H, W]``.

        Raises:
            InputError: If the network refuses the input's size or answers with something that
                is no map of classes.
        """
        answer = self._forward(photo)
        ids = self._ids(answer, photo.shape[1], photo.shape[0])
        return ~np.isin(ids, self._settings.occluders), np.isin(ids, self._settings.sky)

    def _forward(self, photo: Rgb) -> NDArray[np.number]:
        settings = self._settings
        size = (settings.width_px, settings.height_px)
        filter_ = cv2.INTER_AREA if photo.shape[1] > size[0] else cv2.INTER_LINEAR
        scaled = cv2.resize(photo, size, interpolation=filter_).astype(np.float32) / 255.0
        normal = (scaled - np.array(settings.mean)) / np.array(settings.std)
        try:
            self._net.setInput(np.ascontiguousarray(normal.transpose(2, 0, 1)[None], np.float32))
            return np.asarray(self._net.forward())
        except cv2.error as error:
            raise InputError(
                f"{self._path}: the network cannot work on {size[0]}x{size[1]} px "
                f"({_reason(error)}); set 'width_px' and 'height_px' to what it expects"
            ) from None

    def _ids(self, answer: NDArray[np.number], width: int, height: int) -> NDArray[np.int64]:
        """Class ids ``[height, width]``; scores are scaled before the best is taken."""
        maps = answer[0] if answer.ndim in (3, 4) and len(answer) == 1 else answer
        if maps.ndim == 3 and len(maps) == 1:
            maps = maps[0]
        if maps.ndim == 2 and min(maps.shape) > 1:
            nearest = cv2.INTER_NEAREST_EXACT
            ids = maps.astype(np.float32)
            return np.asarray(cv2.resize(ids, (width, height), interpolation=nearest), np.int64)
        if maps.ndim != 3:
            shape = "x".join(str(side) for side in answer.shape)
            raise InputError(
                f"{self._path}: the network's answer has the shape {shape}, which is no map of "
                "classes (1 x classes x h x w, or 1 x h x w); name a segmentation network"
            )
        if (highest := max((*self._settings.sky, *self._settings.occluders))) >= len(maps):
            raise InputError(
                f"{self._path}: the network knows {len(maps)} classes, but the settings name "
                f"class {highest}; correct 'sky' and 'occluders' of 'network'"
            )
        return _best(maps.astype(np.float32), width, height)


def _try_in_child(path: Path, settings: NetworkSettings) -> None:
    """Run the network once in another process, which OpenCV ends on some damaged files.

    Raises:
        InputError: If it did. What OpenCV merely refuses is left to the caller, who has words.
    """
    size = str(settings.height_px), str(settings.width_px)
    command = [sys.executable, "-c", _CHILD, str(path.absolute()), *size]
    done = subprocess.run(command, capture_output=True, check=False)
    if done.returncode < 0:
        raise InputError(
            f"{path}: OpenCV breaks down over this network (signal {-done.returncode}); export it "
            "to ONNX again, with a common opset such as 13"
        )


def _best(scores: NDArray[np.float32], width: int, height: int) -> NDArray[np.int64]:
    """Argmax over classes ``[C, h, w]`` at another size, one class in memory at a time."""
    best = np.full((height, width), -np.inf, np.float32)
    ids = np.zeros((height, width), np.int64)
    for number, score in enumerate(scores):
        scaled = cv2.resize(score, (width, height), interpolation=cv2.INTER_LINEAR)
        is_better = scaled > best
        ids[is_better], best[is_better] = number, scaled[is_better]
    return ids


def _reason(error: cv2.error) -> str:
    """The last part of OpenCV's message, in one line."""
    return " ".join(str(error.err or error).split()).rstrip(".") or "no reason given"
