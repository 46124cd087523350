"""Break one training iteration down by part: rasterizer, splats, losses, Adam, everything else.

Prints a table and writes results/benchmarks/training_step.csv. Workloads: random Gaussians that
cover every pixel, and, where `make all` has run, the trained embedded scenes. Milliseconds of the
whole iteration are medians without profiler; the parts' shares come from torch's profiler.

    python benchmarks/training_step.py [--threads 1 --threads 2]
"""

import gc
import os
import statistics
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click
import pandas as pd
import torch
from torch.profiler import ProfilerActivity, profile

from r3gw.files import atomic_path
from r3gw.files.provenance import peak_rss_mb
from r3gw.files.strict import read_yaml
from r3gw.geometry.cameras import Camera
from r3gw.model.initial import InitialPoints
from r3gw.model.model import SceneModel
from r3gw.model.model_file import load_model
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.native import ops
from r3gw.scene import load_scene
from r3gw.training.objective import objective
from r3gw.training.optimizer import adam_step
from r3gw.training.photos import Photo, load_photos
from r3gw.training.schedule import Schedule
from r3gw.training.settings import TrainSettings, load_train_settings
from r3gw.training.start import initial_model
from r3gw.training.state import TrainingState, first_state

ROOT = Path(__file__).parents[1]
TARGET = Path("results/benchmarks/training_step.csv")
PARTS = {
    "rasterizer": ("project", "project_backward", "composite", "composite_backward"),
    "splats": ("splats", "splats_backward"),
    "picture_losses": ("picture_losses",),
}
WARM_UP, ROUNDS, COUNTED = 5, 8, 8


@dataclass(frozen=True)
class Workload:
    """A model and the photos that it is trained on."""

    name: str
    model: SceneModel
    settings: TrainSettings
    photos: list[Photo]


def slab(count: int, width: int, height: int) -> Workload:
    """``count`` random foreground Gaussians (a tenth of them sky) that cover the picture."""
    settings = TrainSettings.model_validate(read_yaml(ROOT / "config/train.yaml"))
    generator = torch.Generator().manual_seed(0)
    num_sky = count // 10
    points = torch.rand(count - num_sky, 3, generator=generator)
    points = points * torch.tensor([8.0, 6.0, 4.0]) - torch.tensor([4.0, 3.0, -4.0])
    dome = SkyDome(torch.tensor([0.0, 3.0, 0.0]), 12.0, (-0.8, 0.8))
    initial = InitialPoints(points, dome, sample_dome(dome, num_sky, generator))
    model = initial_model(initial, ("slab",), settings)
    with torch.no_grad():
        noise = 0.5 * torch.randn(count - num_sky, 3, generator=generator)
        model.foreground["log_scales"].copy_(
            noise + torch.tensor(0.06 * (2e4 / count) ** 0.5).log()
        )
        model.foreground["quaternions"].copy_(torch.randn(count - num_sky, 4, generator=generator))
        logits = 1.5 * torch.randn(count - num_sky, generator=generator) + 0.5
        model.foreground["opacity_logits"].copy_(logits)
    focal = 0.9 * width
    camera = Camera(
        torch.eye(4, dtype=torch.float64), (focal, focal, width / 2, height / 2), width, height
    )
    planes = torch.randint(0, 256, (3, height, width), generator=generator, dtype=torch.uint8)
    is_sky = torch.zeros(height, width, dtype=torch.bool)
    is_sky[: height // 3] = True
    photo = Photo("slab", camera, planes, torch.ones_like(is_sky), is_sky)
    return Workload(f"slab-{count // 1000}k", model, settings, [photo])


def trained() -> Iterator[Workload]:
    """The embedded scenes, if they have been trained."""
    for path in sorted(Path("results").glob("*/full/seed0/model.safetensors")):
        folder = path.parents[2]
        photos = load_photos(load_scene(folder / "scene"), folder / "scene", folder / "masks")
        settings = load_train_settings(path.with_name("settings.json"))
        yield Workload(folder.name, load_model(path), settings, photos)


def step(state: TrainingState, photos: list[Photo], schedule: Schedule) -> None:
    """One iteration with all losses, without densification."""
    state.iteration += 1
    index = state.iteration % len(photos)
    late = schedule.iterations
    rendering, loss, _ = objective(
        state.model,
        state.settings,
        photos[index],
        index,
        late,
        schedule,
        state.generator,
        state.sun_shadows,
    )
    torch.autograd.backward(loss)
    camera, gradient = photos[index].camera, rendering.means2d.grad
    if gradient is not None:
        state.statistics.add(gradient, rendering.radii_px, camera.width, camera.height)
    adam_step(state.optimizer)
    state.model.sky.clamp_to_dome()


def measure(workload: Workload, threads: int) -> dict[str, str | int | float]:
    """One row of the table."""
    torch.set_num_threads(threads)
    settings = workload.settings
    state, schedule = first_state(workload.model, settings), Schedule.of(settings)
    for _ in range(WARM_UP):
        step(state, workload.photos, schedule)
    times: list[float] = []
    own_ms: dict[str, float] = {}
    # In turn, because the machine's speed drifts: the parts belong to the iterations around them.
    for _ in range(ROUNDS):
        for _ in range(COUNTED):
            start = time.perf_counter()
            step(state, workload.photos, schedule)
            times.append(1e3 * (time.perf_counter() - start))
        with profile(activities=[ProfilerActivity.CPU]) as profiler:
            for _ in range(COUNTED):
                step(state, workload.photos, schedule)
        for event in profiler.key_averages():
            spent = event.self_cpu_time_total / 1e3 / COUNTED / ROUNDS
            own_ms[event.key] = own_ms.get(event.key, 0.0) + spent
    total = statistics.median(times)
    row: dict[str, str | int | float] = {
        "workload": workload.name,
        "gaussians": workload.model.num_gaussians,
        "width": workload.photos[0].camera.width,
        "height": workload.photos[0].camera.height,
        "threads": threads,
        "iteration_ms": total,
    }
    for part, names in PARTS.items():
        row[f"{part}_ms"] = sum(own_ms.get(f"r3gw::{name}", 0.0) for name in names)
    row["adam_ms"] = own_ms.get("r3gw::adam_step", 0.0)
    known = sum(float(row[f"{part}_ms"]) for part in (*PARTS, "adam"))
    row["rest_ms"] = total - known
    row["others_by_rasterizer"] = (total - float(row["rasterizer_ms"])) / float(
        row["rasterizer_ms"]
    )
    row["peak_rss_mb"] = peak_rss_mb()
    row["load"] = os.getloadavg()[0]
    return row


@click.command()
@click.option("--threads", type=int, multiple=True, default=(1, 2), show_default=True)
def main(threads: tuple[int, ...]) -> None:
    """Print where the time of one training iteration goes."""
    ops.keep_freed_memory()  # this and the next as a training does
    gc.freeze()
    rows = []
    for count in threads:
        for workload in (slab(20_000, 320, 240), slab(100_000, 640, 480), *trained()):
            rows.append(measure(workload, count))
            print(pd.DataFrame(rows[-1:]).to_string(index=False, header=len(rows) == 1))
    frame = pd.DataFrame(rows)
    with atomic_path(TARGET) as path:
        frame.to_csv(path, index=False, float_format="%.5g")


if __name__ == "__main__":
    main()
