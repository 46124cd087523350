"""Time the rasterizer beside a naive scalar kernel and the plain-torch reference.

Prints a table and writes results/benchmarks/rasterizer.csv. Every row runs in a process of its
own, so that its peak memory is its own; times are medians. Run it on an otherwise idle machine:
the column ``load`` says what else was running.

    python benchmarks/rasterizer.py [--quick]
"""

import json
import os
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import pandas as pd
import torch
from workloads import Drawing, workloads

from r3gw.files import atomic_path
from r3gw.raster import reference  # Loads torch.ops.r3gw too.

TARGET = Path("results/benchmarks/rasterizer.csv")
COLUMNS = [
    *("kernel", "workload", "gaussians", "width", "height", "channels", "threads"),
    *("project_ms", "forward_ms", "backward_ms", "pairs_per_s", "peak_rss_mb", "load"),
]
TRAINING_CHANNELS, TRAINING_GRADIENTS = 9, 7
SECONDS_PER_ROW = 4.0


def repeat(parts: list[tuple[str, Callable[[], Any]]]) -> dict[str, float]:
    """Median milliseconds of each part, run in turn for about SECONDS_PER_ROW."""
    times: dict[str, list[float]] = {name: [] for name, _ in parts}
    end = time.perf_counter() + SECONDS_PER_ROW
    while time.perf_counter() < end or len(times[parts[0][0]]) < 3:
        for name, part in parts:
            start = time.perf_counter()
            part()
            times[name].append(1e3 * (time.perf_counter() - start))
    return {name: statistics.median(values[1:]) for name, values in times.items()}


def time_kernels(drawing: Drawing, naive: bool) -> dict[str, float]:
    """Milliseconds of project, forward and backward (both halves) of r3gw or the naive kernel."""
    ops: Any = torch.ops.r3gw
    ops.keep_freed_memory()  # as a training does
    geometry = (drawing.means, drawing.quaternions, drawing.scales)
    opacities, features = drawing.opacities, drawing.features
    size, channels = (drawing.width, drawing.height), features.shape[1]
    camera = (drawing.cam_from_world, drawing.intrinsics, *size)
    grad_planes = torch.randn(channels, drawing.height, drawing.width)
    grad_alpha = torch.randn(drawing.height, drawing.width)
    columns = TRAINING_GRADIENTS if channels == TRAINING_CHANNELS else channels
    state: dict[str, Any] = {}

    def project() -> None:
        state["projected"] = ops.project(*geometry, opacities, *camera)

    def forward() -> None:
        means2d, factors, screen, radii = state["projected"]
        state["drawn"] = ops.composite(means2d, factors, screen, radii, features, None, *size)

    def backward() -> None:
        means2d, factors, screen, radii = state["projected"]
        planes, alpha, frame = state.pop("drawn")
        to_means2d, to_factors, _, _ = ops.composite_backward(
            *(frame, grad_planes, grad_alpha, planes, alpha, means2d, factors, screen),
            *(opacities, features, columns),
        )
        ops.project_backward(to_means2d, to_factors, *geometry, radii, *camera)

    if not naive:
        return repeat([("project", project), ("forward", forward), ("backward", backward)])
    kernel, grad_image = naive_kernel(), grad_planes.permute(1, 2, 0).contiguous()

    def naive_forward() -> None:
        _, _, state["pairs"] = kernel.forward(*state["projected"], opacities, features, *size)

    def naive_backward() -> None:
        kernel.backward(grad_image, grad_alpha, opacities, features)

    parts = [("project", project), ("forward", naive_forward), ("backward", naive_backward)]
    return repeat(parts) | {"pairs": state["pairs"]}


def naive_kernel() -> Any:
    """Compile (once; cached by torch) the comparison kernel."""
    from torch.utils.cpp_extension import load

    source = Path(__file__).parent / "csrc/naive_rasterizer.cpp"
    flags = ["-O3", "-march=native"]
    return load("r3gw_naive_rasterizer", [str(source)], extra_cflags=flags)


def time_reference(drawing: Drawing) -> dict[str, float]:
    """Milliseconds of the plain-torch reference; its projection counts as forward."""
    tensors = (drawing.means, drawing.quaternions, drawing.scales, drawing.opacities)
    inputs = [value.requires_grad_() for value in (*tensors, drawing.features)]
    camera = (drawing.cam_from_world, drawing.intrinsics, drawing.width, drawing.height)
    state: dict[str, torch.Tensor] = {}

    def forward() -> None:
        result = reference.rasterize(*inputs, *camera)
        state["loss"] = result.features.sum() + result.alpha.sum()

    def backward() -> None:
        state["loss"].backward()  # type: ignore[no-untyped-call]

    return repeat([("forward", forward), ("backward", backward)]) | {"project": 0.0}


def measure(kernel: str, name: str, channels: int, threads: int) -> dict[str, Any]:
    """One row, in this process."""
    torch.set_num_threads(threads)
    drawing = workloads()[name].drawing(channels)
    if kernel == "reference":
        times = time_reference(drawing)
    else:
        times = time_kernels(drawing, naive=kernel == "naive")
    return {
        "kernel": kernel,
        "workload": name,
        "gaussians": len(drawing.means),
        "width": drawing.width,
        "height": drawing.height,
        "channels": channels,
        "threads": threads,
        **{f"{part}_ms": times[part] for part in ("project", "forward", "backward")},
        "pairs": times.get("pairs"),
        "peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "load": os.getloadavg()[0],
    }


def rows_to_measure(quick: bool) -> list[tuple[str, str, int, int]]:
    """(kernel, workload, channels, threads), the naive kernel first: it counts the pairs."""
    rows = []
    for workload in list(workloads().values())[: 2 if quick else None]:
        rows.append(("naive", workload.name, 3, 1))
        if workload.with_reference:
            rows.append(("reference", workload.name, 3, 1))
        for channels in (3, TRAINING_CHANNELS) if quick else (3, 8, TRAINING_CHANNELS, 16):
            rows += [("r3gw", workload.name, channels, threads) for threads in (1, 2)]
    return rows


@click.command()
@click.option("--quick", is_flag=True, help="Only the two small workloads, fewer channel counts.")
@click.option("--row", help="Used by the program itself: measure one row, print it as JSON.")
def main(quick: bool, row: str | None) -> None:
    """Time the rasterizer; print a table and write results/benchmarks/rasterizer.csv."""
    if row is not None:
        click.echo(json.dumps(measure(*json.loads(row))))
        return
    rows: list[dict[str, Any]] = []
    pairs: dict[str, float] = {}
    for wanted in rows_to_measure(quick):
        command = [sys.executable, __file__, "--row", json.dumps(wanted)]
        output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
        result = json.loads(output.splitlines()[-1])
        pairs.setdefault(result["workload"], result.pop("pairs"))
        milliseconds = result["forward_ms"] + result["backward_ms"]
        result["pairs_per_s"] = 1e3 * pairs[result["workload"]] / milliseconds
        rows.append(result)
        click.echo("  ".join(str(result[key]) for key in COLUMNS), err=True)
    table = pd.DataFrame(rows)[COLUMNS]
    TARGET.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(TARGET) as path:
        table.to_csv(path, index=False, float_format="%.4g")
    click.echo(table.to_markdown(index=False, floatfmt=".4g"))


if __name__ == "__main__":
    main()
