"""One evaluated run as the figures see it: records, pictures, lights, history."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.files import read_linear, read_rgb
from r3gw.lighting.light import Light
from r3gw.relight.files.lights_file import read_lights
from r3gw.reporting.tables.table1 import method_name
from r3gw.scene import Scene, View

BY_KNOWLEDGE = ("exact", "learned", "nerf-osr", "full-yaw", "nerf-osr-linear")


@dataclass(frozen=True)
class Relit:
    """Which pictures the evaluation rendered under other lights (r3gw.evaluation.gallery).

    Attributes:
        folder: Where they are.
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


@dataclass(frozen=True)
class Evaluated:
    """A run's folder, read.

    Attributes:
        variant: Name of the variant.
        run: run.json of the training.
        records: Image records by (view, protocol).
        parts: Decomposition records by view.
        renders: Folder of the pictures.
        relit: What was rendered under other lights.
        lights: What was learned for every training photo.
        history: history.csv of the training.
    """

    variant: str
    run: dict[str, Any]
    records: dict[tuple[str, str], dict[str, Any]]
    parts: dict[str, dict[str, Any]]
    renders: Path
    relit: Relit
    lights: dict[str, Light]
    history: pd.DataFrame

    @property
    def label(self) -> str:
        """How the variant is called in print, short."""
        return method_name(self.variant).removeprefix("r3gw").strip(" ,") or "full"

    def picture(self, view: str, kind: str) -> NDArray[np.uint8] | None:
        """A rendered picture ``[H, W, 3]``; None if the evaluation did not make it."""
        path = self.renders / kind / f"{view}.png"
        return read_rgb(path) if path.is_file() else None

    def depth(self, view: str) -> NDArray[np.float32]:
        """Rendered depth ``[H, W]``, world units, 0 where there is no foreground."""
        return read_linear(self.renders / "depth" / f"{view}.exr")[..., 0]

    def psnr(self, view: str, protocol: str) -> str:
        """The PSNR as a label; empty if the view was not scored so."""
        record = self.records.get((view, protocol))
        return "" if record is None else f"{record['psnr']:.2f} dB"

    def shown_views(self, scene: Scene) -> list[View]:
        """Test views that were evaluated; where there are none, training views with pictures."""
        for split in (scene.split("test"), scene.split("train")):
            if shown := [v for v in split if (self.renders / "truth" / f"{v.name}.png").is_file()]:
                return shown
        return []

    def protocol_of(self, view: str) -> str:
        """The protocol that shows the view best: the one that knows most about its light."""
        return next(name for name in BY_KNOWLEDGE if (view, name) in self.records)


def read_run(folder: Path) -> Evaluated:
    """Read ``folder``/history.csv and ``folder``/metrics/.

    Raises:
        InputError: If a file is missing.
    """
    metrics, history = folder / "metrics", folder / "history.csv"
    relit = metrics / "relit" / "relit.json"
    for path in (metrics / "metrics.json", metrics / "lights.json", relit, history):
        if not path.is_file():
            raise InputError(f"{path}: no such file; train and evaluate the run first")
    content = json.loads((metrics / "metrics.json").read_text())
    shown = json.loads(relit.read_text())
    parts: dict[str, dict[str, Any]] = {}
    for record in content["decomposition"]:
        parts.setdefault(record["view"], {}).update(record)
    return Evaluated(
        variant=content["run"]["variant"],
        run=content["run"],
        records={(record["view"], record["protocol"]): record for record in content["images"]},
        parts=parts,
        renders=metrics / "renders",
        relit=Relit(relit.parent, shown["views"], shown["map"], shown["yaws_deg"], shown["photos"]),
        lights=read_lights(metrics),
        history=pd.read_csv(history),
    )
