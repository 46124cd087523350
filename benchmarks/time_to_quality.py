"""PSNR of training photos over the processor's seconds, for several settings of one scene in turn.

    python benchmarks/time_to_quality.py results/chapel results/chapel/full/seed0/settings.json \
        before='{}' after='{"resolution": {"smallest": 0.25, "whole_from": 15000}}'

Every NAME=JSON is a run: the given settings with these changes. The runs take turns, a fortieth of
each at a time, so that all of them meet the same drift of a busy machine; only seconds in which a
run's own process computed count, and those of the pictures that are compared do not. Test photos
are not looked at. Prints a row per point and writes results/benchmarks/time_to_quality.csv and
.svg; how long each run takes to the first run's last PSNR stands below.
"""

import gc
import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.evaluation.protocols.learned import Learned
from r3gw.files import atomic_path
from r3gw.files.strict import read_yaml
from r3gw.model.initial import load_initial
from r3gw.native import ops
from r3gw.scene import load_scene
from r3gw.training.first_values import with_first_values
from r3gw.training.loop import step
from r3gw.training.photos import camera_extent, load_photos
from r3gw.training.resolution import PhotoSizes
from r3gw.training.schedule import Schedule
from r3gw.training.settings import TrainSettings
from r3gw.training.start import model_of_photos
from r3gw.training.state import first_state

TARGET = Path("results/benchmarks/time_to_quality.csv")
TURNS, POINTS, MOST_PHOTOS = 40, 8, 16


class Run:
    """One training in steps."""

    def __init__(self, name: str, place: Path, settings: TrainSettings) -> None:
        """Load the scene's photos and its first points."""
        self.name, self.place = name, place
        self.scene = load_scene(place / "scene")
        photos = load_photos(self.scene, place / "scene", place / "masks")
        settings = with_first_values(settings, photos)
        views = self.scene.split("train")
        sessions = tuple(view.session or view.name for view in views)
        initial = load_initial(place / "initial.npz")
        model = model_of_photos(initial, photos, settings, sessions)
        self.state, self.schedule = first_state(model, settings), Schedule.of(settings)
        self.sizes = PhotoSizes(photos, self.schedule)
        self.extent = camera_extent([photo.camera for photo in photos])
        self.compared = list(views[:: max(1, len(views) // MOST_PHOTOS)])
        self.seconds = 0.0

    def advance(self, turn: int) -> None:
        """Train up to the end of a turn, which counts from 1."""
        self.state.model.appearance.train()
        start = time.process_time()
        while self.state.iteration < round(self.state.settings.iterations * turn / TURNS):
            step(self.state, self.sizes, self.schedule, self.extent, None)
        self.seconds += time.process_time() - start

    def row(self) -> dict[str, str | int | float]:
        """What is reached so far."""
        model = self.state.model
        model.appearance.eval()
        place = self.place
        evaluated = EvaluatedScene(model, self.scene, place / "scene", place / "masks")
        figures = [Learned().evaluate(evaluated, view).figures for view in self.compared]
        means = {
            key: float(np.mean([figure[key] for figure in figures if key in figure]))
            for key in ("psnr", "ssim", "psnr_foreground")
        }
        return {
            "run": self.name,
            "seed": self.state.settings.seed,
            "iteration": self.state.iteration,
            "seconds": self.seconds,
            **means,
            "foreground": len(model.foreground),
            "sky": len(model.sky.rows),
        }


def changed(values: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Settings with changes, group by group."""
    result = dict(values)
    for key, value in changes.items():
        result[key] = changed(result[key], value) if isinstance(value, dict) else value
    return result


def seconds_to(rows: pd.DataFrame, psnr: float) -> float:
    """When a run's curve first reaches a PSNR, between its points along a line; NaN if never."""
    seconds, reached = rows.seconds.to_numpy(), rows.psnr.to_numpy()
    above = np.flatnonzero(reached >= psnr)
    if len(above) == 0:
        return float("nan")
    at = above[0]
    if at == 0:
        return float(seconds[0])
    share = (psnr - reached[at - 1]) / (reached[at] - reached[at - 1])
    return float(seconds[at - 1] + share * (seconds[at] - seconds[at - 1]))


def plot(frame: pd.DataFrame, target: Path) -> None:
    """A line per run."""
    figure = Figure(figsize=(5, 3), layout="constrained")
    axes = figure.subplots()
    for name, rows in frame.groupby("run", sort=False):
        axes.plot(rows.seconds, rows.psnr, "o-", label=str(name))
    axes.set_xlabel("processor seconds")
    axes.set_ylabel("PSNR of training photos, dB")
    axes.legend(frameon=False)
    with atomic_path(target) as path:
        figure.savefig(path)


@click.command()
@click.argument("place", type=click.Path(path_type=Path, exists=True))
@click.argument("settings", type=click.Path(path_type=Path, exists=True))
@click.argument("runs", nargs=-1, required=True)
@click.option("--seed", "seeds", type=int, multiple=True, default=(0,), show_default=True)
@click.option("--threads", type=int, default=1, show_default=True)
@click.option("--target", type=click.Path(path_type=Path), default=TARGET, show_default=True)
def main(
    place: Path,
    settings: Path,
    runs: tuple[str, ...],
    seeds: tuple[int, ...],
    threads: int,
    target: Path,
) -> None:
    """Train all runs of a scene's folder in turn and compare them."""
    torch.set_num_threads(threads)
    ops.keep_freed_memory()  # this and the next as a training does
    given = read_yaml(settings)
    rows = []
    for seed in seeds:
        started = []
        for run in runs:
            name, _, changes = run.partition("=")
            values = changed(given, json.loads(changes) | {"seed": seed})
            started.append(Run(name, place, TrainSettings.model_validate(values)))
        gc.freeze()
        for turn in range(1, TURNS + 1):
            for each in started:
                each.advance(turn)
                if turn % (TURNS // POINTS) == 0:
                    rows.append(each.row())
                    print(pd.DataFrame(rows[-1:]).to_string(index=False, header=False), flush=True)
    frame = pd.DataFrame(rows)
    for drawn, of_seed in frame.groupby("seed"):
        first = of_seed[of_seed.run == of_seed.run.iloc[0]]
        psnr = first.psnr.iloc[-1]
        for run_name, of_run in of_seed.groupby("run", sort=False):
            print(f"seed {drawn}, {run_name}: {seconds_to(of_run, psnr):.1f} s to {psnr:.2f} dB")
    with atomic_path(target) as path:
        frame.to_csv(path, index=False, float_format="%.5g")
    plot(
        frame.groupby(["run", "iteration"], sort=False).mean().reset_index(),
        target.with_suffix(".svg"),
    )


if __name__ == "__main__":
    main()
