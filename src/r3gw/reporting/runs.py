"""One training and its evaluation, as tables, figures and the report read it."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from r3gw.evaluation.protocols import facts
from r3gw.files import InputError
from r3gw.imaging.files import read_linear, read_rgb
from r3gw.reporting.columns import Record, figures_of
from r3gw.reporting.methods import method_of
from r3gw.reporting.relit import Relit, read_relit
from r3gw.scene import Scene, View

if TYPE_CHECKING:
    import r3gw.lighting.light


@dataclass(frozen=True)
class Run:
    """One training of one variant on one scene, evaluated.

    Attributes:
        folder: metrics/ of the run; pictures and lights are beside metrics.json, history.csv is
            in the folder above.
        scene, variant, seed: Which one.
        provenance: The training's run.json.
        figures: Means over views by name of column; what the scene does not allow is absent.
        images: The record of every image and protocol.
        decomposition: The records of what was compared with ground truth, and of the sky's outline.
    """

    folder: Path
    scene: str
    variant: str
    seed: int
    provenance: Record
    figures: Mapping[str, float]
    images: Sequence[Record]
    decomposition: Sequence[Record]

    @property
    def label(self) -> str:
        """How the variant is called above pictures."""
        return method_of(self.variant).label

    @property
    def num_gaussians(self) -> int:
        """Foreground and sky together."""
        return int(self.provenance["num_foreground"]) + int(self.provenance["num_sky"])

    @cached_property
    def records(self) -> Mapping[tuple[str, str], Record]:
        """Image records by view and protocol."""
        return {(record["view"], record["protocol"]): record for record in self.images}

    @cached_property
    def cost(self) -> Mapping[str, float]:
        """Seconds and memory of the training and of the evaluation: cost.json.

        Raises:
            InputError: If there is no such file, or it is of an earlier version.
        """
        path = _existing(self.folder / "cost.json")
        cost: dict[str, float] = json.loads(path.read_text())
        if "training_seconds" not in cost:
            raise InputError(f"{path}: holds no training_seconds; evaluate the run again")
        return cost

    @cached_property
    def lights(self) -> Mapping[str, "r3gw.lighting.light.Light"]:
        """Per training photo the light and sky that were learned for it.

        Only pictures need them, so torch is not loaded for tables.

        Raises:
            InputError: If the evaluation did not write them.
        """
        from r3gw.relight.files.lights_file import read_lights

        _existing(self.folder / "lights.json")
        return read_lights(self.folder)

    @cached_property
    def history(self) -> pd.DataFrame:
        """history.csv of the training.

        Raises:
            InputError: If there is no such file.
        """
        return pd.read_csv(_existing(self.folder.with_name("history.csv")))

    @cached_property
    def relit(self) -> Relit:
        """The pictures under other lights.

        Raises:
            InputError: If the evaluation did not make them.
        """
        return read_relit(self.folder / "relit")

    def picture_path(self, view: str, kind: str) -> Path:
        """Where the picture of a view is, if it was made; kinds are protocols and parts."""
        return self.folder / "renders" / kind / f"{view}.png"

    def picture(self, view: str, kind: str) -> NDArray[np.uint8] | None:
        """A rendered picture ``[H, W, 3]``; None if the evaluation did not make it."""
        path = self.picture_path(view, kind)
        return read_rgb(path) if path.is_file() else None

    def psnr(self, view: str, protocol: str) -> str:
        """The PSNR as a label; empty if the view was not scored so."""
        record = self.records.get((view, protocol))
        return "" if record is None else f"{record['psnr']:.2f} dB"

    def depth(self, view: str) -> NDArray[np.float32]:
        """Rendered depth ``[H, W]``, world units, 0 where there is no foreground."""
        return read_linear(self.picture_path(view, "depth").with_suffix(".exr"))[..., 0]

    def boundary_psnr(self, view: str) -> float | None:
        """PSNR within 5 px of the sky's outline; None where a view shows none."""
        for record in self.decomposition:
            if record["view"] == view and "sky_boundary_psnr" in record:
                return float(record["sky_boundary_psnr"])
        return None

    def shown_views(self, scene: Scene) -> list[View]:
        """Test views that were evaluated; where there are none, training views with pictures."""
        for split in (scene.split("test"), scene.split("train")):
            if shown := [view for view in split if self._has_surfaces(view)]:
                return shown
        return []

    def _has_surfaces(self, view: View) -> bool:
        return self.picture_path(view.name, "albedo").is_file()

    def protocol_of(self, view: str) -> str:
        """The protocol that shows the view best: the one of the lowest rank."""
        ranked = sorted(facts.PROTOCOLS, key=lambda protocol: protocol.rank)
        return next(each.name for each in ranked if (view, each.name) in self.records)


def load_runs(metrics_files: Iterable[Path]) -> list[Run]:
    """Read metrics.json of several runs, in the order given.

    Raises:
        InputError: If there is none, one is missing or malformed, or two are of the same run.
    """
    runs = [load_run(path) for path in metrics_files]
    if not runs:
        raise InputError("a table needs at least one metrics.json; evaluate a run first")
    seen = set()
    for run in runs:
        key = (run.scene, run.variant, run.seed)
        if key in seen:
            raise InputError(
                f"two metrics.json are of scene {run.scene}, variant {run.variant}, "
                f"seed {run.seed}; give each run once"
            )
        seen.add(key)
    return runs


def load_run(path: Path) -> Run:
    """Read one metrics.json.

    Raises:
        InputError: If the file is missing or malformed.
    """
    _existing(path)
    try:
        content = json.loads(path.read_text())
        provenance = content["run"]
        return Run(
            folder=path.parent,
            scene=provenance["scene"],
            variant=provenance["variant"],
            seed=provenance["seed"],
            provenance=provenance,
            figures=figures_of(content["images"], content["decomposition"]),
            images=content["images"],
            decomposition=content["decomposition"],
        )
    except (json.JSONDecodeError, KeyError, TypeError) as error:
        raise InputError(
            f"{path}: not a metrics file of this version ({error!r}); evaluate the run again"
        ) from error


def _existing(path: Path) -> Path:
    if not path.is_file():
        raise InputError(f"{path}: no such file; train and evaluate the run first")
    return path
