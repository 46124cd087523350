"""What a schedule has given after 1, 2, 5 thousand iterations, from the snapshots of its runs.

Trainings write snapshots when they are asked to (`r3gw train --snapshot 1000 --snapshot 2000`).
Every snapshot of every run is evaluated here as a finished run is, unless that lies beside it
already; lengths.csv has a row for each, lengths.png figures over iterations, lengths_views.png a
test view, its albedo and normals and a learned light at each length.

    python benchmarks/lengths.py --scene results/chapel --target results/benchmarks RUN...
"""

from collections.abc import Iterator, Mapping, Sequence
from math import isqrt
from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from r3gw.evaluation.stage import evaluate_run
from r3gw.files import atomic_path, write_json
from r3gw.files.strict import read_json
from r3gw.imaging.colour import display_array_from_linear
from r3gw.imaging.files import read_rgb
from r3gw.imaging.pictures import bytes_from_display
from r3gw.lighting import envmap
from r3gw.model.lights import learned_lights
from r3gw.model.model_file import load_model
from r3gw.reporting.figures.style import Cell, look, new_figure, picture_grid, save

PLOTTED = ("psnr_exact", "psnr_nerf-osr", "psnr_train", "albedo_psnr", "normal_median_deg")
SURFACES = ("albedo_psnr", "normal_median_deg")
LIGHT_HEIGHT_PX = 90
RECENT = 10  # rows of history.csv that a training PSNR is the mean of


def snapshots(run: Path) -> list[Path]:
    """The run's snapshots, by length."""
    return sorted((run / "snapshots").iterdir(), key=lambda path: int(path.name))


def evaluated(scene: Path, snapshot: Path) -> Mapping[str, Any]:
    """metrics.json of a snapshot, made where it is not there yet."""
    target = snapshot / "evaluation"
    if not (target / "metrics.json").is_file():
        model = snapshot / "model.safetensors"
        evaluate_run(scene / "scene", scene / "masks", model, target, num_threads=1)
        write_json(target / "bands.json", band_energies(model))
    return read_json(target / "metrics.json")


def band_energies(model: Path) -> dict[str, float]:
    """Mean over photos and channels of the squares of each band's coefficients, summed."""
    lights = np.stack(
        [np.asarray(light.sh) for light in learned_lights(load_model(model)).values()]
    )
    degree = isqrt(lights.shape[1]) - 1
    return {
        f"light_band_{band}": float(
            np.square(lights[:, band**2 : (band + 1) ** 2]).sum(axis=1).mean()
        )
        for band in range(degree + 1)
    }


def row_of(scene: Path, run: Path, snapshot: Path) -> dict[str, Any]:
    """The figures of one snapshot."""
    metrics = evaluated(scene, snapshot)
    images = pd.DataFrame(metrics["images"])
    means = images.groupby("protocol")[["psnr", "ssim"]].mean()
    surfaces = pd.DataFrame([r for r in metrics["decomposition"] if "albedo_psnr" in r])
    history = pd.read_csv(snapshot / "history.csv")
    timing, record = read_json(snapshot / "timing.json"), metrics["run"]
    return {
        "run": run.name,
        "iterations": int(snapshot.name),
        **{f"psnr_{name}": means.psnr[name] for name in means.index},
        **{f"ssim_{name}": means.ssim[name] for name in means.index},
        "psnr_train": history.psnr.tail(RECENT).mean(),
        **{name: surfaces[name].mean() for name in SURFACES if name in surfaces},
        **read_json(snapshot / "evaluation" / "bands.json"),
        "num_foreground": record["num_foreground"],
        "num_sky": record["num_sky"],
        "seconds": timing["training_seconds"],
        "peak_rss_mb": timing["peak_rss_mb"],
    }


def plot(table: pd.DataFrame) -> Figure:
    """A panel per figure, a line per run, over iterations."""
    shown = [name for name in PLOTTED if name in table]
    figure = new_figure(2.6 * len(shown), 2.4)
    for index, name in enumerate(shown):
        axes = figure.add_subplot(1, len(shown), index + 1)
        for run, rows in table.groupby("run", sort=False):
            axes.semilogx(rows.iterations, rows[name], marker="o", markersize=3, label=run)
        axes.set_title(name.replace("_", " "), fontsize=8)
        axes.set_xlabel("iterations", fontsize=7)
        axes.tick_params(labelsize=7)
    figure.axes[0].legend(fontsize=7)
    figure.tight_layout()
    return figure


def views(runs: Sequence[Path]) -> Figure:
    """A test view, its albedo and normals and a learned light; a row of each for every run.

    A column is a length, empty where a run has no snapshot of it.
    """
    lengths = sorted({int(each.name) for run in runs for each in snapshots(run)})
    rows, names = [], []
    for run in runs:
        for kind in ("exact", "albedo", "normal", "light"):
            rows.append([picture(run / "snapshots" / str(length), kind) for length in lengths])
            names.append(f"{run.name}: {kind}")
    return picture_grid(rows, [f"{length:,}" for length in lengths], names)


def picture(snapshot: Path, kind: str) -> Cell | None:
    """The first test view as one of evaluation's pictures, or the first photo's light.

    None where there is no such snapshot.
    """
    if not snapshot.is_dir():
        return None
    if kind == "light":
        light = next(iter(learned_lights(load_model(snapshot / "model.safetensors")).values()))
        drawn = envmap.draw(light.sh, LIGHT_HEIGHT_PX).numpy()
        return Cell(bytes_from_display(display_array_from_linear(drawn)))
    folder = snapshot / "evaluation" / "renders"
    found = next(iter(sorted((folder / "exact").glob("*.png"))), None)
    return None if found is None else Cell(read_rgb(folder / kind / found.name))


def rows_of(scene: Path, runs: Sequence[Path]) -> Iterator[dict[str, Any]]:
    """A row for every snapshot of every run."""
    for run in runs:
        for snapshot in snapshots(run):
            yield row_of(scene, run, snapshot)


@click.command()
@click.option("--scene", type=Path, required=True, help="Folder with scene/ and masks/.")
@click.option("--target", type=Path, default=Path("results/benchmarks"), show_default=True)
@click.argument("runs", type=Path, nargs=-1, required=True)
def main(scene: Path, target: Path, runs: tuple[Path, ...]) -> None:
    """Evaluate all snapshots of RUNS and tabulate, plot and picture them."""
    table = pd.DataFrame(rows_of(scene, runs))
    print(table.round(3).to_string(index=False))
    target.mkdir(parents=True, exist_ok=True)
    with atomic_path(target / "lengths.csv") as path:
        table.to_csv(path, index=False, float_format="%.5g")
    with look():
        save(plot(table), target / "lengths.png", as_pdf=False)
        save(views(runs), target / "lengths_views.png", as_pdf=False)


if __name__ == "__main__":
    main()
