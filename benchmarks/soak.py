"""Does a process that trains for long grow? Many short trainings one after another, and a long one.

After every short training, and at every twentieth of the long one: resident memory, open files,
threads and files left in the folder for temporary ones. Every training densifies, casts shadows,
saves checkpoints and continues from one; every model is written and read. Prints a summary, writes
results/benchmarks/soak.csv and ends with status 1 if anything has grown after the first third.

    python benchmarks/soak.py [--trainings 200] [--iterations 5000]
"""

import os
import sys
import tempfile
from pathlib import Path

import click
import pandas as pd
import torch
from training_step import Workload, slab

from r3gw.files.atomic import atomic_path
from r3gw.lighting import sh
from r3gw.model.model_file import load_model, save_model
from r3gw.model.rows import OCCLUSION
from r3gw.training.checkpoint import Checkpoints
from r3gw.training.loop import train
from r3gw.training.settings import TrainSettings
from r3gw.training.state import TrainingState

TARGET = Path("results/benchmarks/soak.csv")
GAUSSIANS, WIDTH, HEIGHT = 2000, 80, 60
SHORT_ITERATIONS, CHECKPOINT_AT, LONG_ROWS = 30, 20, 20
# What may come on top from one third to the next: pages that the allocator keeps, and no file.
ALLOWED = {"rss_mb": 10.0, "open_files": 0.0, "threads": 0.0, "temporary_files": 0.0}


def measured(folder: Path) -> dict[str, float]:
    """What must not grow: of this process, and the files in ``folder``."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return {
        "rss_mb": pages * os.sysconf("SC_PAGE_SIZE") / 1e6,
        "open_files": float(len(list(Path("/proc/self/fd").iterdir()))),
        "threads": float(len(list(Path("/proc/self/task").iterdir()))),
        "temporary_files": float(len(list(folder.iterdir()))),
    }


class Watched(Checkpoints):
    """Checkpoints that also measure, every ``interval`` iterations."""

    def __init__(self, folder: Path, interval: int) -> None:
        """Save into ``folder``."""
        super().__init__(folder, {"run": "soak"}, interval_s=0.0)
        self.folder, self.interval = folder, interval
        self.rows: list[dict[str, float]] = []

    def save_if_due(self, state: TrainingState) -> None:
        """Save and measure where due; the file that stands is always the same one."""
        if state.iteration % self.interval == 0:
            super().save_if_due(state)
            self.rows.append(measured(self.folder))


def workload(iterations: int) -> tuple[Workload, TrainSettings]:
    """A fresh slab that casts shadows, and settings of a length for as many Gaussians."""
    made = slab(GAUSSIANS, WIDTH, HEIGHT)
    rows = made.model.foreground
    rows.add_computed(OCCLUSION, torch.zeros(len(rows), sh.num_coefficients(4)))
    changes = {"max_gaussians": GAUSSIANS, "reset_interval": None, "min_opacity": 1e-6}
    density = made.settings.density.model_copy(update=changes)
    at_the_end = {"enabled": True, "voxels": 32, "first": made.settings.paper_iterations}
    occlusion = made.settings.occlusion.model_copy(update=at_the_end)
    changed = {"iterations": iterations, "density": density, "occlusion": occlusion}
    return made, made.settings.model_copy(update=changed)


def short_training(folder: Path) -> dict[str, float]:
    """Train, again from the checkpoint, write and read; return what is left behind."""
    made, settings = workload(SHORT_ITERATIONS)
    checkpoints = Watched(folder, CHECKPOINT_AT)
    train(made.model, made.photos, settings, checkpoints)
    again = train(made.model, made.photos, settings, Watched(folder, SHORT_ITERATIONS))
    save_model(again.model, folder / "model.safetensors")
    load_model(folder / "model.safetensors")
    (folder / "model.safetensors").unlink()
    checkpoints.discard()
    return measured(folder)


def long_training(folder: Path, iterations: int) -> list[dict[str, float]]:
    """Train once; return the measurements on the way."""
    made, settings = workload(iterations)
    checkpoints = Watched(folder, iterations // LONG_ROWS)
    train(made.model, made.photos, settings, checkpoints)
    checkpoints.discard()
    return checkpoints.rows


def grown(table: pd.DataFrame) -> pd.DataFrame:
    """Median of the second and of the last third of each series, and what came on top."""
    found = []
    for kind, rows in table.groupby("kind"):
        third = len(rows) // 3
        middle, last = rows.iloc[third : 2 * third], rows.iloc[2 * third :]
        for name, allowed in ALLOWED.items():
            before, after = float(middle[name].median()), float(last[name].median())
            found.append(
                {"kind": kind, "what": name, "second_third": before, "last_third": after}
                | {"is_flat": after - before <= allowed}
            )
    return pd.DataFrame(found)


@click.command()
@click.option("--trainings", type=click.IntRange(6), default=200, show_default=True)
@click.option("--iterations", type=click.IntRange(LONG_ROWS), default=5000, show_default=True)
def main(trainings: int, iterations: int) -> None:
    """Train many times and once for long; say whether anything grew."""
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = [{"kind": "short", **short_training(folder)} for _ in range(trainings)]
        rows += [{"kind": "long", **row} for row in long_training(folder, iterations)]
    table = pd.DataFrame(rows)
    with atomic_path(TARGET) as path:
        table.to_csv(path, index=False, float_format="%.6g")
    summary = grown(table)
    print(summary.to_string(index=False))
    sys.exit(0 if summary["is_flat"].all() else 1)


if __name__ == "__main__":
    main()
