"""One evaluated run as the figures see it: records, pictures, lights, history."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.files import read_linear, read_rgb
from r3gw.reporting.tables import method_name


@dataclass(frozen=True)
class Evaluated:
    """A run's folder, read.

    Attributes:
        variant: Name of the variant.
        records: Image records by (view, protocol).
        renders: Folder of the pictures.
        lights: Per training photo ``light`` and ``sky`` coefficients.
        history: history.csv of the training.
    """

    variant: str
    records: dict[tuple[str, str], dict[str, Any]]
    renders: Path
    lights: dict[str, dict[str, list[list[float]]]]
    history: pd.DataFrame

    @property
    def label(self) -> str:
        """How the variant is called in print, short."""
        return method_name(self.variant).removeprefix("r3gw").strip(" ,") or "full"

    def picture(self, view: str, kind: str) -> NDArray[np.uint8] | None:
        """A rendered picture ``[H, W, 3]``; None if the evaluation did not make it."""
        path = self.renders / f"{view}_{kind}.png"
        return read_rgb(path) if path.is_file() else None

    def depth(self, view: str) -> NDArray[np.float32]:
        """Rendered depth ``[H, W]``, world units, 0 where there is no foreground."""
        return read_linear(self.renders / f"{view}_depth.exr")[..., 0]

    def psnr(self, view: str, protocol: str) -> str:
        """The PSNR as a label; empty if the view was not scored so."""
        record = self.records.get((view, protocol))
        return "" if record is None else f"{record['psnr']:.2f} dB"


def read_run(folder: Path) -> Evaluated:
    """Read ``folder``/history.csv and ``folder``/metrics/.

    Raises:
        InputError: If a file is missing.
    """
    metrics, history = folder / "metrics", folder / "history.csv"
    for path in (metrics / "metrics.json", metrics / "lights.json", history):
        if not path.is_file():
            raise InputError(f"{path}: no such file; train and evaluate the run first")
    content = json.loads((metrics / "metrics.json").read_text())
    return Evaluated(
        content["run"]["variant"],
        {(record["view"], record["protocol"]): record for record in content["images"]},
        metrics / "renders",
        json.loads((metrics / "lights.json").read_text()),
        pd.read_csv(history),
    )
