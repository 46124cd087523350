"""A made-up scene and made-up evaluated runs: pictures of one colour each, so that places show."""

from pathlib import Path

import numpy as np
import pandas as pd
import torch

from r3gw.files import write_json
from r3gw.geometry.similarity import Similarity
from r3gw.imaging.files import write_exr, write_image
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.model.initial import initial_points, save_initial
from r3gw.model.settings import SkySettings
from r3gw.relight.files.lights_file import write_lights
from r3gw.scene import Points, Scene, View, save_points, save_scene
from r3gw.scene.scene import Gauge

RED, GREEN, BLUE = (255, 0, 0), (0, 255, 0), (0, 0, 255)


def plain(colour: tuple[int, int, int]) -> np.ndarray:
    """A picture of one colour, 12x16."""
    return np.full((12, 16, 3), colour, np.uint8)


def view(name: str, split: str) -> View:
    """A view of no particular camera."""
    return View(
        name=name,
        image=f"images/{name}.png",
        width=16,
        height=12,
        intrinsics=(10.0, 10.0, 8.0, 6.0),
        cam_from_world=((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
        split=split,
        session="s",
    )


def make_scene(folder: Path, *, with_test: bool) -> Path:
    """A scene of one training view and, if asked for, one test view; masks and points beside it."""
    views = [view("t", "train")] + ([view("v", "test")] if with_test else [])
    gauge = Gauge.of(Similarity.identity())
    scene = Scene(name="x", source_format="photos", views=tuple(views), scene_from_source=gauge)
    save_scene(scene, folder)
    is_sky = np.zeros((12, 16), np.bool_)
    is_sky[:5] = True
    for each in views:
        write_image(folder / each.image, plain(GREEN))
        write_image(folder.with_name("masks") / "is_sky" / f"{each.name}.png", is_sky)
        write_image(folder.with_name("masks") / "is_valid" / f"{each.name}.png", is_sky | True)
    xyz = np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32)
    save_points(Points(xyz, np.full((50, 3), 90, np.uint8)), folder)
    sky = SkySettings(
        count_per_radius=10.0,
        min_count=20,
        max_count=30,
        azimuth_range="cameras",
        around="scene",
        least_opacity=0.0,
        is_closed=False,
    )
    cameras = [each.camera for each in views]
    initial = initial_points(torch.from_numpy(xyz), cameras, sky, seed=0)
    save_initial(initial, folder.with_name("initial.npz"))
    return folder


def make_run(folder: Path, variant: str, *, with_test: bool) -> Path:
    """An evaluated run's folder with pictures of one colour."""
    metrics = folder / "metrics"
    figures = {"psnr": 25.0, "ssim": 0.9, "mse": 0.01, "mae": 0.05}
    records = [{"view": "t", "protocol": "learned", **figures}]
    if with_test:
        sweep = {"sweep_angles_rad": [0.0, 0.5, 1.0], "sweep_psnr": [1.0, 3.0, 2.0]}
        records.append(
            {"view": "v", "protocol": "nerf-osr", **figures, "psnr": 3.0, "angle_rad": 0.5, **sweep}
        )
    for record in records:
        name = record["view"]
        for kind in ("albedo", "normal", "sky", "foreground", record["protocol"]):
            write_image(metrics / "renders" / kind / f"{name}.png", plain(BLUE))
        write_exr(
            metrics / "renders" / "depth" / f"{name}.exr", np.full((12, 16, 3), 5, np.float32)
        )
    _make_relit(metrics / "relit", [record["view"] for record in records][-1:])
    run = {
        "scene": "x", "variant": variant, "seed": 0, "iterations": 3, "num_foreground": 40,
        "num_sky": 20, "num_threads": 1, "settings_digest": f"digest-{variant}",
        "code_version": "0.1.0", "machine": "<machine & co>",
    }  # fmt: skip
    parts = [{"view": "t", "sky_boundary_psnr": 21.0}, {"view": "t", "light_error": 0.5}]
    write_json(metrics / "metrics.json", {"run": run, "images": records, "decomposition": parts})
    sky = LearnedSky(torch.zeros(4, 3))
    write_lights({"t": Light(torch.tensor([[1.0, 0.5, 0.2]] * 4), sky)}, "scene", metrics)
    cost = {"renders_per_second": 50.0, "render_megapixels": 1.0, "render_threads": 1}
    cost |= {"peak_rss_mb": 300.0, "training_seconds": 60.0, "training_peak_rss_mb": 500.0}
    write_json(metrics / "cost.json", cost)
    is_full = variant == "full"
    write_json(folder / "settings.json", {"model": {"specular": is_full}, "iterations": 3})
    columns = ("iteration", "loss", "psnr", "num_foreground", "num_sky")
    history = {name: [1.0, 2.0, 3.0] for name in columns}
    pd.DataFrame(history).to_csv(folder / "history.csv", index=False)
    return folder


def _make_relit(folder: Path, views: list[str]) -> None:
    """Relit pictures: red under the map, its brightness telling the turn; green when learned."""
    yaws_deg = [0, 90, 180, 270]
    for yaw_deg in yaws_deg:
        for name in (*views, "light"):
            write_image(
                folder / "map" / f"{name}_{yaw_deg:03d}.png", plain((255 - yaw_deg // 2, 0, 0))
            )
    for name in (*views, "light"):
        write_image(folder / "learned" / f"{name}_0.png", plain(GREEN))
    shown = {"views": views, "map": "a map", "yaws_deg": yaws_deg, "photos": ["t"]}
    write_json(folder / "relit.json", shown)
