"""Where the rasterizer's second thread waits, counted in the processor's time.

    python benchmarks/threads.py [--threads 2]

On a machine that others use too, the clock says more of them than of the kernels. So each thread's
own time is counted: threads that wait sleep (OMP_WAIT_POLICY=passive) and count nothing.
*Inflation* is the processor's time of all threads over that of one alone: what caches, bandwidth
and bookkeeping cost. *Busiest* is the time of the busiest thread, which is how long the part takes
if every thread has a core; one alone over it is the speed-up. One and several threads take turns;
the least of all rounds counts, because a thread that has to give way to another process leaves its
tiles to the others. Prints a table and writes results/benchmarks/threads.csv, with the share that
only one thread can do, by Amdahl's law, and what four and eight threads would reach.
"""

import os

os.environ["OMP_WAIT_POLICY"] = "passive"  # Before OpenMP starts.

import time
from pathlib import Path
from typing import Any

import click
import pandas as pd
import torch
from workloads import Drawing, workloads

from r3gw.files import atomic_path
from r3gw.native import ops as native
from r3gw.rendering.channels import NUM_CHANNELS, NUM_LEARNED

TARGET = Path("results/benchmarks/threads.csv")
NAMES = ("slab-20k", "slab-100k", "slab-200k")
PARTS = ("project", "composite", "composite_backward", "project_backward")
ROUNDS = 30


def thread_times() -> dict[str, int]:
    """Nanoseconds that each thread of this process has computed so far, by its number."""
    return {
        task.name: int((task / "schedstat").read_text().split()[0])
        for task in Path("/proc/self/task").iterdir()
    }


def once(drawing: Drawing) -> dict[str, list[float]]:
    """Milliseconds of each thread that did anything, busiest first, by part."""
    ops: Any = torch.ops.r3gw
    geometry = (drawing.means, drawing.quaternions, drawing.scales)
    size = (drawing.width, drawing.height)
    camera = (drawing.cam_from_world, drawing.intrinsics, *size)
    channels = drawing.features.shape[1]
    columns = NUM_LEARNED if channels == NUM_CHANNELS else channels
    to_planes = torch.ones(channels, drawing.height, drawing.width)
    found = {}

    def timed(part: str, *arguments: Any) -> Any:
        before = thread_times()
        result = getattr(ops, part)(*arguments)
        time.sleep(2e-4)  # The others count up to when they fall asleep.
        spent = [now - before.get(name, 0) for name, now in thread_times().items()]
        found[part] = sorted((1e-6 * ns for ns in spent if ns > 0), reverse=True)
        return result

    projected = timed("project", *geometry, drawing.opacities, *camera)
    planes, alpha, frame = timed("composite", *projected, drawing.features, None, *size)
    to_means2d, to_factors, *_ = timed(
        "composite_backward",
        *(frame, to_planes, None, planes, alpha, *projected[:3]),
        *(drawing.opacities, drawing.features, columns, False),
    )
    timed("project_backward", to_means2d, to_factors, *geometry, projected[3], *camera)
    return found


def measure(name: str, channels: int, threads: int) -> dict[str, str | int | float]:
    """A row of the table."""
    drawing = workloads()[name].drawing(channels)
    alone: list[float] = []
    busiest: list[float] = []
    together: list[float] = []
    for _ in range(ROUNDS):
        torch.set_num_threads(1)
        alone.append(sum(sum(times) for times in once(drawing).values()))
        torch.set_num_threads(threads)
        several = once(drawing)
        together.append(sum(sum(times) for times in several.values()))
        busiest.append(sum(times[0] for times in several.values()))
    one, critical, total = min(alone), min(busiest), min(together)
    speed_up = one / critical
    serial = max((threads / speed_up - 1) / (threads - 1), 0.0)
    return {
        "workload": name,
        "channels": channels,
        "threads": threads,
        "alone_ms": one,
        "busiest_ms": critical,
        "inflation": total / one,
        "speed_up": speed_up,
        "serial_share": serial,
        "four_threads": 1 / (serial + (1 - serial) / 4),
        "eight_threads": 1 / (serial + (1 - serial) / 8),
        "load": os.getloadavg()[0],
    }


@click.command()
@click.option("--threads", type=click.IntRange(2), default=2, show_default=True)
def main(threads: int) -> None:
    """Measure the slabs."""
    native.keep_freed_memory()  # as a training does
    rows = []
    for name in NAMES:
        for channels in (3, NUM_CHANNELS):
            rows.append(measure(name, channels, threads))
            table = pd.DataFrame(rows[-1:]).to_string(index=False, header=len(rows) == 1)
            print(table, flush=True)
    with atomic_path(TARGET) as path:
        pd.DataFrame(rows).to_csv(path, index=False, float_format="%.5g")


if __name__ == "__main__":
    main()
