"""Peak memory of trainings that begin with all their Gaussians, and what the doctor predicts.

Milliseconds are of the processor, one thread; casting the shadows once is in them.

Each row is a training of a few iterations in a process of its own, of a seeded slab before twenty
photos (training_step.py), without and with shadows. Prints a table and writes
results/benchmarks/training_memory.csv. The constants are in r3gw.pipeline.doctor.cost.

    python benchmarks/training_memory.py
"""

import multiprocessing
import time
from dataclasses import replace
from pathlib import Path

import click
import pandas as pd
import torch
from training_step import slab

from r3gw.files import atomic_path
from r3gw.files.provenance import peak_rss_mb
from r3gw.lighting import sh
from r3gw.model.rows import OCCLUSION
from r3gw.native import ops
from r3gw.pipeline.doctor.training import SceneSize, predicted
from r3gw.training.loop import train

TARGET = Path("results/benchmarks/training_memory.csv")
SIZES = ((240, 180, 25_000), (640, 480, 60_000), (1280, 850, 300_000), (1600, 1200, 200_000))
PHOTOS, ITERATIONS = 20, 12


def measure(job: tuple[int, int, int, bool]) -> dict[str, str | int | float]:
    """One training's peak memory in MB, and the prediction."""
    width, height, count, has_shadows = job
    torch.set_num_threads(1)
    ops.keep_freed_memory()  # as a training does
    workload = slab(count, width, height)
    (photo,) = workload.photos
    photos = [replace(photo, planes=photo.planes.clone()) for _ in range(PHOTOS)]
    given = workload.settings
    never = {"first": 10**9, "reset_interval": None, "max_gaussians": count}
    once = {"first": 10**9}  # after the last iteration alone
    settings = given.model_copy(
        update={
            "iterations": ITERATIONS,
            "density": given.density.model_copy(update=never),
            "occlusion": given.occlusion.model_copy(update=once | {"enabled": has_shadows}),
        }
    )
    if has_shadows:
        size = sh.num_coefficients(settings.model.light_degree)
        workload.model.foreground.add_computed(
            OCCLUSION, torch.zeros(len(workload.model.foreground), size)
        )
    start = time.process_time()
    train(workload.model, photos, settings)
    seconds = time.process_time() - start
    pixels = PHOTOS * width * height
    scene = SceneSize(foreground=count, sky=0, photos=PHOTOS, photo_pixels=pixels)
    return {
        "photos": f"{width}x{height}",
        "gaussians": count,
        "shadows": has_shadows,
        "iteration_ms": round(1e3 * seconds / ITERATIONS),
        "peak_mb": round(peak_rss_mb()),
        "predicted_mb": round(predicted(settings, scene).memory_mb),
    }


@click.command()
def main() -> None:
    """Measure every size without and with shadows."""
    jobs = [(*size, has_shadows) for has_shadows in (False, True) for size in SIZES]
    with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
        table = pd.DataFrame(pool.map(measure, jobs, chunksize=1))
    table["ratio"] = table.peak_mb / table.predicted_mb
    print(table.to_string(index=False, float_format="%.2f"))
    with atomic_path(TARGET) as path:
        table.to_csv(path, index=False, float_format="%.4g")


if __name__ == "__main__":
    main()
