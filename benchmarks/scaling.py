"""Growth of one training iteration with the number of Gaussians and of pixels.

Prints a table, writes results/benchmarks/scaling.csv and a log-log plot beside it. Every row runs
in a process of its own, so that its peak memory is its own.

    python benchmarks/scaling.py [--threads 2]
"""

import multiprocessing
import os
import time
from pathlib import Path

import click
import matplotlib as mpl
import numpy as np
import pandas as pd
import torch
from training_step import slab, step

from r3gw.files import atomic_path
from r3gw.files.provenance import peak_rss_mb
from r3gw.native import ops
from r3gw.training.schedule import Schedule
from r3gw.training.state import first_state

mpl.use("Agg")
TARGET = Path("results/benchmarks/scaling.csv")
COUNTS = (5_000, 10_000, 20_000, 50_000, 100_000, 200_000, 500_000)
SIZES = ((160, 120), (320, 240), (640, 480), (1280, 960))
FIXED_COUNT, FIXED_SIZE = 50_000, (320, 240)
SECONDS_PER_ROW = 5.0


def measure(job: tuple[str, int, int, int, int]) -> dict[str, str | int | float]:
    """Least milliseconds of an iteration (see rasterizer.py) and the process's peak memory."""
    series, count, width, height, threads = job
    torch.set_num_threads(threads)
    ops.keep_freed_memory()  # as a training does
    workload = slab(count, width, height)
    settings = workload.settings
    state, schedule = first_state(workload.model, settings), Schedule.of(settings)
    times: list[float] = []
    end = time.perf_counter() + SECONDS_PER_ROW
    while time.perf_counter() < end or len(times) < 5:
        start = time.perf_counter()
        step(state, workload.photos, schedule)
        times.append(1e3 * (time.perf_counter() - start))
    return {
        "series": series,
        "gaussians": count,
        "width": width,
        "height": height,
        "threads": threads,
        "iteration_ms": min(times),
        "peak_rss_mb": peak_rss_mb(),
        "load": os.getloadavg()[0],
    }


def with_slopes(frame: pd.DataFrame) -> pd.DataFrame:
    """Add the log-log slope between each row and the one before it in its series."""
    size = np.where(frame.series == "gaussians", frame.gaussians, frame.width * frame.height)
    by_series = frame.assign(log_size=np.log(size), log_ms=np.log(frame.iteration_ms))
    steps = by_series.groupby("series")[["log_size", "log_ms"]].diff()
    return frame.assign(slope=steps.log_ms / steps.log_size)


def plot(frame: pd.DataFrame, target: Path) -> None:
    """Iteration time against size, both logarithmic, with a line of slope 1 for the eye."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 3), layout="constrained")
    for axes, (series, rows) in zip(
        figure.subplots(1, 2, sharey=True), frame.groupby("series"), strict=True
    ):
        size = rows.gaussians if series == "gaussians" else rows.width * rows.height
        axes.loglog(size, rows.iteration_ms, "o-", label="measured")
        anchor = rows.iteration_ms.iloc[-1] / size.iloc[-1]
        axes.loglog(size, anchor * size, "--", color="grey", label="slope 1")
        axes.set_xlabel("pixels in the picture" if series == "pixels" else "Gaussians")
        axes.legend(frameon=False)
    figure.axes[0].set_ylabel("ms per training iteration")
    with atomic_path(target) as path:
        figure.savefig(path)


@click.command()
@click.option("--threads", type=int, default=2, show_default=True)
def main(threads: int) -> None:
    """Measure growth over Gaussians and over pixels."""
    jobs = [("gaussians", count, *FIXED_SIZE, threads) for count in COUNTS]
    jobs += [("pixels", FIXED_COUNT, *size, threads) for size in SIZES]
    with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
        frame = with_slopes(pd.DataFrame(pool.map(measure, jobs, chunksize=1)))
    print(frame.to_string(index=False, float_format="%.3g"))
    with atomic_path(TARGET) as path:
        frame.to_csv(path, index=False, float_format="%.5g")
    plot(frame, TARGET.with_suffix(".svg"))


if __name__ == "__main__":
    main()
