"""Time the rasterizer beside a naive scalar kernel and the plain-torch reference.

Prints a table and writes results/benchmarks/rasterizer.csv. Every kernel, workload and number of
channels runs in a process of its own, so that its peak memory is its own; numbers of threads take
turns in it, since a machine's speed drifts. Times are the least of a part's runs, as timeit
advises: what neighbours on the machine add belongs to no kernel. Run it on an otherwise idle
machine: the column ``load`` says what else was running.

    python benchmarks/rasterizer.py [--quick]
"""

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click
import pandas as pd
import torch
from workloads import Drawing, workloads

from r3gw.files import atomic_path
from r3gw.native import ops as native  # Loads torch.ops.r3gw too.
from r3gw.raster import reference
from r3gw.rendering.channels import NUM_CHANNELS, NUM_LEARNED

TARGET = Path("results/benchmarks/rasterizer.csv")
COLUMNS = [
    *("kernel", "workload", "gaussians", "width", "height", "channels", "threads"),
    *("project_ms", "forward_ms", "backward_ms", "pairs_per_s", "peak_rss_mb", "load"),
]
SECONDS_PER_ROW = 4.0
BOTH = (1, 2)

Part = tuple[str, Callable[[], Any]]


def repeat(parts: list[Part], threads: Sequence[int]) -> dict[int, dict[str, float]]:
    """Per number of threads, least milliseconds of each part; all run in turn."""
    times: dict[tuple[int, str], list[float]] = {
        (n, name): [] for n in threads for name, _ in parts
    }
    end = time.perf_counter() + SECONDS_PER_ROW * len(threads)
    while time.perf_counter() < end or len(times[threads[0], parts[0][0]]) < 3:
        for count in threads:
            torch.set_num_threads(count)
            for name, part in parts:
                start = time.perf_counter()
                part()
                times[count, name].append(1e3 * (time.perf_counter() - start))
    return {count: {name: min(times[count, name]) for name, _ in parts} for count in threads}


def time_kernels(
    drawing: Drawing, naive: bool, threads: Sequence[int]
) -> dict[int, dict[str, float]]:
    """Milliseconds of project, forward and backward (both halves) of r3gw or the naive kernel."""
    ops: Any = torch.ops.r3gw
    native.keep_freed_memory()  # as a training does
    geometry = (drawing.means, drawing.quaternions, drawing.scales)
    opacities, features = drawing.opacities, drawing.features
    size, channels = (drawing.width, drawing.height), features.shape[1]
    camera = (drawing.cam_from_world, drawing.intrinsics, *size)
    grad_planes = torch.randn(channels, drawing.height, drawing.width)
    grad_alpha = torch.randn(drawing.height, drawing.width)
    columns = NUM_LEARNED if channels == NUM_CHANNELS else channels
    state: dict[str, Any] = {}

    def project() -> None:
        state["projected"] = ops.project(*geometry, opacities, *camera)

    def forward() -> None:
        means2d, factors, screen, radii = state["projected"]
        state["drawn"] = ops.composite(means2d, factors, screen, radii, features, None, *size)

    def backward() -> None:
        means2d, factors, screen, radii = state["projected"]
        planes, alpha, frame = state.pop("drawn")
        to_means2d, to_factors, *_ = ops.composite_backward(
            *(frame, grad_planes, grad_alpha, planes, alpha, means2d, factors, screen),
            *(opacities, features, columns, False),
        )
        ops.project_backward(to_means2d, to_factors, *geometry, radii, *camera)

    if not naive:
        return repeat([("project", project), ("forward", forward), ("backward", backward)], threads)
    kernel, grad_image = naive_kernel(), grad_planes.permute(1, 2, 0).contiguous()

    def naive_forward() -> None:
        _, _, state["pairs"] = kernel.forward(*state["projected"], opacities, features, *size)

    def naive_backward() -> None:
        kernel.backward(grad_image, grad_alpha, opacities, features)

    parts = [("project", project), ("forward", naive_forward), ("backward", naive_backward)]
    times = repeat(parts, threads)
    return {count: values | {"pairs": state["pairs"]} for count, values in times.items()}


def naive_kernel() -> Any:
    """Compile (once; cached by torch) the comparison kernel."""
    from torch.utils.cpp_extension import load

    source = Path(__file__).parent / "csrc/naive_rasterizer.cpp"
    flags = ["-O3", "-march=native"]
    return load("r3gw_naive_rasterizer", [str(source)], extra_cflags=flags)


def time_reference(drawing: Drawing, threads: Sequence[int]) -> dict[int, dict[str, float]]:
    """Milliseconds of the plain-torch reference; its projection counts as forward."""
    splats = (
        drawing.means.requires_grad_(),
        drawing.quaternions.requires_grad_(),
        drawing.scales.requires_grad_(),
        drawing.opacities.requires_grad_(),
        drawing.features.requires_grad_(),
    )
    camera = (drawing.cam_from_world, drawing.intrinsics, drawing.width, drawing.height)
    state: dict[str, torch.Tensor] = {}

    def forward() -> None:
        result = reference.rasterize(*splats, *camera)
        state["loss"] = result.features.sum() + result.alpha.sum()

    def backward() -> None:
        state["loss"].backward()  # type: ignore[no-untyped-call]

    times = repeat([("forward", forward), ("backward", backward)], threads)
    return {count: values | {"project": 0.0} for count, values in times.items()}


def measure(kernel: str, name: str, channels: int, threads: Sequence[int]) -> list[dict[str, Any]]:
    """A row per number of threads, in this process."""
    drawing = workloads()[name].drawing(channels)
    if kernel == "reference":
        times = time_reference(drawing, threads)
    else:
        times = time_kernels(drawing, kernel == "naive", threads)
    return [
        {
            "kernel": kernel,
            "workload": name,
            "gaussians": len(drawing.means),
            "width": drawing.width,
            "height": drawing.height,
            "channels": channels,
            "threads": count,
            **{f"{part}_ms": spent[part] for part in ("project", "forward", "backward")},
            "pairs": spent.get("pairs"),
            "peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
            "load": os.getloadavg()[0],
        }
        for count, spent in times.items()
    ]


def processes(quick: bool) -> list[tuple[str, str, int, Sequence[int]]]:
    """(kernel, workload, channels, threads), the naive kernel first: it counts the pairs."""
    wanted: list[tuple[str, str, int, Sequence[int]]] = []
    for workload in list(workloads().values())[: 2 if quick else None]:
        wanted.append(("naive", workload.name, 3, (1,)))
        if workload.with_reference:
            wanted.append(("reference", workload.name, 3, (1,)))
        for channels in (3, NUM_CHANNELS) if quick else (3, 8, NUM_CHANNELS, 16):
            wanted.append(("r3gw", workload.name, channels, BOTH))
    return wanted


@click.command()
@click.option("--quick", is_flag=True, help="Only the two small workloads, fewer channel counts.")
@click.option("--process", help="Used by the program itself: measure, print rows as JSON.")
def main(quick: bool, process: str | None) -> None:
    """Time the rasterizer; print a table and write results/benchmarks/rasterizer.csv."""
    if process is not None:
        click.echo(json.dumps(measure(*json.loads(process))))
        return
    rows: list[dict[str, Any]] = []
    pairs: dict[str, float] = {}
    for wanted in processes(quick):
        command = [sys.executable, __file__, "--process", json.dumps(wanted)]
        output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
        for row in json.loads(output.splitlines()[-1]):
            pairs.setdefault(row["workload"], row.pop("pairs"))
            milliseconds = row["forward_ms"] + row["backward_ms"]
            row["pairs_per_s"] = 1e3 * pairs[row["workload"]] / milliseconds
            rows.append(row)
            click.echo("  ".join(str(row[key]) for key in COLUMNS), err=True)
    table = pd.DataFrame(rows)[COLUMNS]
    TARGET.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(TARGET) as path:
        table.to_csv(path, index=False, float_format="%.4g")
    click.echo(table.to_markdown(index=False, floatfmt=".4g"))


if __name__ == "__main__":
    main()
