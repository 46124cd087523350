"""Time the rasterizer beside a naive scalar kernel and the plain-torch reference.

Prints a table and writes results/benchmarks/rasterizer.csv. Every row runs in a process of its
own, so that its peak memory is its own; times are medians. Run it on an otherwise idle machine:
the column ``load`` says what else was running.

    python benchmarks/rasterizer.py [--quick]
"""

import json
import math
import os
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import pandas as pd
import torch

from r3gw.files import atomic_path
from r3gw.raster import reference  # Loads torch.ops.r3gw too.

TARGET = Path("results/benchmarks/rasterizer.csv")
COLUMNS = [
    *("kernel", "workload", "gaussians", "width", "height", "channels", "threads"),
    *("project_ms", "forward_ms", "backward_ms", "pairs_per_s", "peak_rss_mb", "load"),
]
TRAINING_CHANNELS, TRAINING_GRADIENTS = 9, 7
SECONDS_PER_ROW = 4.0


@dataclass(frozen=True)
class Workload:
    """A seeded slab of Gaussians in front of an identity camera (rasterizer.md)."""

    name: str
    gaussians: int
    width: int
    height: int
    opacity_shift: float = 0.5
    scale: float = 1.0
    with_reference: bool = False

    def inputs(self, channels: int) -> list[torch.Tensor]:
        """Means, quaternions, scales, opacities, features."""
        n = self.gaussians
        torch.manual_seed(0)
        means = torch.rand(n, 3) * torch.tensor([8.0, 6.0, 4.0]) - torch.tensor([4.0, 3.0, -4.0])
        middle = math.log(self.scale * 0.06 * math.sqrt(20_000 / n))
        scales = torch.exp(torch.randn(n, 3) * 0.5 + middle)
        quaternions = torch.nn.functional.normalize(torch.randn(n, 4), dim=-1)
        opacities = torch.sigmoid(torch.randn(n) * 1.5 + self.opacity_shift)
        return [means, quaternions, scales, opacities, torch.rand(n, channels)]

    @property
    def intrinsics(self) -> list[float]:
        focal = 0.9 * self.width
        return [focal, focal, self.width / 2, self.height / 2]


WORKLOADS = {
    workload.name: workload
    for workload in (
        Workload("tiny", 2_000, 80, 60, with_reference=True),
        Workload("slab-20k", 20_000, 320, 240),
        Workload("sparse-50k", 50_000, 640, 480, opacity_shift=-2.0, scale=0.4),
        Workload("slab-100k", 100_000, 640, 480),
        Workload("slab-200k", 200_000, 1024, 768),
    )
}


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


def time_kernels(workload: Workload, channels: int, naive: bool) -> dict[str, float]:
    """Milliseconds of project, forward and backward (both halves) of r3gw or the naive kernel."""
    means, quaternions, scales, opacities, features = workload.inputs(channels)
    ops: Any = torch.ops.r3gw
    size = (workload.width, workload.height)
    camera = (torch.eye(4), workload.intrinsics, *size)
    grad_image = torch.randn(workload.height, workload.width, channels)
    grad_alpha = torch.randn(workload.height, workload.width)
    columns = TRAINING_GRADIENTS if channels == TRAINING_CHANNELS else channels
    state: dict[str, Any] = {}

    def project() -> None:
        state["projected"] = ops.project(means, quaternions, scales, opacities, *camera)

    def forward() -> None:
        means2d, factors, screen, radii = state["projected"]
        state["drawn"] = ops.composite(means2d, factors, screen, radii, features, None, *size)

    def backward() -> None:
        means2d, factors, screen, radii = state["projected"]
        image, alpha, frame = state.pop("drawn")
        to_means2d, to_factors, _, _ = ops.composite_backward(
            *(frame, grad_image, grad_alpha, image, alpha, means2d, factors, screen),
            *(opacities, features, columns),
        )
        ops.project_backward(to_means2d, to_factors, means, quaternions, scales, radii, *camera)

    if not naive:
        return repeat([("project", project), ("forward", forward), ("backward", backward)])
    kernel = naive_kernel()

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


def time_reference(workload: Workload, channels: int) -> dict[str, float]:
    """Milliseconds of the plain-torch reference; its projection counts as forward."""
    inputs = [value.requires_grad_() for value in workload.inputs(channels)]
    means, quaternions, scales, opacities, features = inputs
    size = (workload.width, workload.height)
    state: dict[str, torch.Tensor] = {}

    def forward() -> None:
        result = reference.rasterize(
            *(means, quaternions, scales, opacities, features),
            *(torch.eye(4), workload.intrinsics, *size),
        )
        state["loss"] = result.features.sum() + result.alpha.sum()

    def backward() -> None:
        state["loss"].backward()  # type: ignore[no-untyped-call]

    return repeat([("forward", forward), ("backward", backward)]) | {"project": 0.0}


def measure(kernel: str, name: str, channels: int, threads: int) -> dict[str, Any]:
    """One row, in this process."""
    torch.set_num_threads(threads)
    workload = WORKLOADS[name]
    if kernel == "reference":
        times = time_reference(workload, channels)
    else:
        times = time_kernels(workload, channels, naive=kernel == "naive")
    return {
        "kernel": kernel,
        "workload": name,
        "gaussians": workload.gaussians,
        "width": workload.width,
        "height": workload.height,
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
    for workload in list(WORKLOADS.values())[: 2 if quick else None]:
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
