"""What the evaluation rendered under other lights (r3gw.evaluation.gallery)."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.files import read_rgb


@dataclass(frozen=True)
class Relit:
    """Two or fewer views under a turning map and under learned lights.

    Attributes:
        folder: Where the pictures are.
        views: Names of the views shown.
        map_name: What the turning map is.
        yaws_deg: Its turns.
        photos: Photos whose learned lights were used.
    """

    folder: Path
    views: Sequence[str]
    map_name: str
    yaws_deg: Sequence[int]
    photos: Sequence[str]

    def turned(self, view: str, yaw_deg: int) -> NDArray[np.uint8]:
        """A view under the turned map."""
        return read_rgb(self.folder / "map" / f"{view}_{yaw_deg:03d}.png")

    def turned_map(self, yaw_deg: int) -> NDArray[np.uint8]:
        """The turned map itself."""
        return read_rgb(self.folder / "map" / f"light_{yaw_deg:03d}.png")

    def learned(self, view: str, number: int) -> NDArray[np.uint8]:
        """A view under the learned light of ``photos[number]``."""
        return read_rgb(self.folder / "learned" / f"{view}_{number}.png")

    def learned_map(self, number: int) -> NDArray[np.uint8]:
        """The learned light of ``photos[number]`` as a map."""
        return read_rgb(self.folder / "learned" / f"light_{number}.png")


def read_relit(folder: Path) -> Relit:
    """Read ``folder``/relit.json.

    Raises:
        InputError: If there is no such file.
    """
    path = folder / "relit.json"
    if not path.is_file():
        raise InputError(f"{path}: no such file; train and evaluate the run first")
    shown = json.loads(path.read_text())
    return Relit(folder, shown["views"], shown["map"], shown["yaws_deg"], shown["photos"])
