"""A tiny scene whose photos are renderings of a known model, so that every figure is known."""

from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np
import pytest
import torch

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.files import write_json
from r3gw.geometry.cameras import Camera
from r3gw.geometry.similarity import Similarity
from r3gw.imaging.files import write_exr, write_image
from r3gw.imaging.pictures import bytes_from_display
from r3gw.lighting import envmap
from r3gw.model.initial import initial_points
from r3gw.model.lights import photo_light
from r3gw.model.model import SceneModel
from r3gw.model.model_file import save_model
from r3gw.rendering.channels import Layers
from r3gw.rendering.compose import render
from r3gw.scene import EvaluationEntry, GroundTruth, Scene, View, load_scene, save_scene
from r3gw.scene.scene import Gauge
from r3gw.training.start import initial_model
from support.settings import train_settings

SIZE = (48, 32)
TRAIN = ("a_0", "a_1")
EXACT, SWEPT = "b_exact", "c_swept"
EXPOSURE, WHITE_BALANCE = 0.8, (1.1, 1.0, 0.9)
SWEEP_RAD, BEST_INDEX, ROTATION_X = (-1.0, 1.5), 17, -1.6
THRESHOLD, SCALE = 0.95, 20.0
RUN = {
    "scene": "tiny", "variant": "full", "seed": 0, "iterations": 1, "settings_digest": "d",
    "code_version": "0", "machine": "m", "num_threads": 1, "num_foreground": 1, "num_sky": 1,
}  # fmt: skip
TIMING = {"training_seconds": 1.0, "peak_rss_mb": 1.0}


@dataclass(frozen=True)
class Tiny:
    """The tiny scene on disk and the model that made it."""

    folder: Path
    masks: Path
    model_path: Path
    model: SceneModel
    env_map: torch.Tensor

    @property
    def evaluated(self) -> EvaluatedScene:
        """The model beside its scene's files."""
        return EvaluatedScene(self.model, load_scene(self.folder), self.folder, self.masks)

    def view(self, name: str) -> View:
        """A view by name."""
        return next(v for v in load_scene(self.folder).views if v.name == name)


@torch.no_grad()
def opacities(model: SceneModel, camera: Camera) -> tuple[torch.Tensor, torch.Tensor]:
    """What foreground and sky cover of each pixel by the training's renderer, ``[H, W, 1]``."""
    light = photo_light(model, "a_0")
    drawn = render(model, camera, light.sh, light.sky_coefficients, Layers.OPACITY)
    foreground = drawn.foreground_opacity
    return foreground[..., None], (drawn.alpha - foreground)[..., None]


@pytest.fixture(scope="session")
def tiny(tmp_path_factory) -> Tiny:
    """Two training views, one test view of each protocol; a bumpy wall under a sky."""
    folder = tmp_path_factory.mktemp("tiny")
    views = {name: _view(name, 0.3 * i) for i, name in enumerate((*TRAIN, EXACT, SWEPT))}
    scene = Scene(
        name="tiny",
        source_format="synthetic",
        views=tuple(views.values()),
        scene_from_source=Gauge.of(Similarity.identity()),
    )
    save_scene(scene, folder)
    model = _model([view.camera for view in scene.views])
    (folder / "run").mkdir()
    save_model(model, folder / "run" / "model.safetensors")
    write_json(folder / "run" / "run.json", RUN)
    write_json(folder / "run" / "timing.json", TIMING)
    hdr, ldr = _env_maps()
    write_exr(folder / "envmaps" / "true.exr", hdr.numpy())
    write_image(folder / "envmaps" / "phone.png", ldr)
    _write_photos(model, views, hdr, ldr, folder)
    return Tiny(folder, folder / "masks", folder / "run" / "model.safetensors", model, hdr)


def _view(name: str, shift: float) -> View:
    evaluation = EvaluationEntry(
        mask=f"given/eval/{name}.png",
        env_map="envmaps/phone.png",
        rotation_rad=(ROTATION_X, 0.0, 0.0),
        threshold=THRESHOLD,
        scale=SCALE,
        sun_angles_rad=SWEEP_RAD,
    )
    truth = GroundTruth(
        exposure=EXPOSURE,
        white_balance=WHITE_BALANCE,
        env_map="envmaps/true.exr",
        albedo=f"ground_truth/albedo/{name}.exr",
        normal=f"ground_truth/normal/{name}.exr",
        depth=f"ground_truth/depth/{name}.exr",
    )
    is_test = name not in TRAIN
    return View(
        name=name,
        image=f"images/{name}.png",
        width=SIZE[0],
        height=SIZE[1],
        intrinsics=(45.0, 45.0, 24.0, 16.0),
        cam_from_world=((1, 0, 0, shift), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
        split="test" if is_test else "train",
        session=name[0],
        evaluation=evaluation if is_test else None,
        truth=truth if name == EXACT else None,
    )


def _model(cameras) -> SceneModel:
    """A wall of Gaussians with varied normals and albedo in the picture's lower two thirds."""
    generator = torch.Generator().manual_seed(0)
    x, y = torch.meshgrid(torch.linspace(-4, 4, 41), torch.linspace(-0.6, 3, 19), indexing="xy")
    xyz = torch.stack([x, y, torch.full_like(x, 6.0)], -1).reshape(-1, 3)
    settings = train_settings()
    sky = settings.sky.model_copy(update={"min_count": 400, "max_count": 400})
    initial = initial_points(xyz, cameras, sky, seed=0)
    model = initial_model(initial, TRAIN, settings)
    rows = model.foreground
    with torch.no_grad():
        rows["means"].copy_(xyz)
        rows["log_scales"].copy_(torch.tensor([-1.9, -1.9, -4.0]).expand(len(xyz), 3))
        rows["quaternions"][:, 1:] = 0.3 * torch.randn(len(xyz), 3, generator=generator)
        rows["opacity_logits"].fill_(3.0)
        rows["albedo_logits"].copy_(torch.randn(len(xyz), 3, generator=generator) - 0.5)
        model.sky.rows["opacity_logits"].fill_(3.0)
        model.sky.rows["log_scales"].add_(1.9)  # a dense dome, three times as large
        model.sky.radius.mul_(3.0)
    model.appearance.eval()
    return model


def _env_maps() -> tuple[torch.Tensor, np.ndarray]:
    """An HDR map with a sun for `exact`, and an 8-bit one with a clipped sun for `nerf-osr`."""
    directions = envmap.pixel_directions(16, 32)
    sun = torch.nn.functional.normalize(torch.tensor([0.6, -0.6, -0.5]).double(), dim=-1)
    is_sun = (directions @ sun > 0.95)[..., None]
    sky = torch.where(directions[..., 1:2] < 0, 0.7, 0.2) * torch.tensor([0.8, 0.9, 1.0])
    hdr = (sky + 12.0 * is_sun * torch.tensor([1.0, 0.9, 0.7])).float()
    return hdr, np.where(is_sun.numpy(), 255, (sky.numpy() * 180)).astype(np.uint8)


@torch.no_grad()
def _write_photos(model, views, hdr, ldr, folder: Path) -> None:
    """Photos by projecting the maps straight in their final orientation."""
    true = envmap.project(hdr, envmap.pixel_directions(16, 32), 4)
    true = true * EXPOSURE * torch.tensor(WHITE_BALANCE)
    angle = np.linspace(*SWEEP_RAD, 51)[BEST_INDEX]
    values = ldr.astype(np.float32) / 255
    bright = torch.from_numpy(np.where(values > THRESHOLD, values * SCALE, values))
    phone = envmap.project(bright, envmap.published_directions(16, 32, ROTATION_X, float(angle)), 4)
    lights = {EXACT: (true, None), SWEPT: (phone, None)}
    lights |= {name: model.appearance(i)[:2] for i, name in enumerate(TRAIN)}
    is_lower = np.zeros((SIZE[1], SIZE[0]), np.bool_)
    is_lower[14:] = True
    for name, (light, sky_light) in lights.items():
        colour = render(model, views[name].camera, light, sky_light).colour
        write_image(folder / "images" / f"{name}.png", bytes_from_display(colour))
        write_image(folder / "masks" / "is_valid" / f"{name}.png", np.ones_like(is_lower))
        write_image(folder / "masks" / "is_sky" / f"{name}.png", ~is_lower)
        write_image(folder / "given" / "eval" / f"{name}.png", is_lower)
    for kind, value in (("albedo", 0.5), ("normal", 1.0), ("depth", 6.0)):
        picture = np.zeros((SIZE[1], SIZE[0], 3), np.float32)
        picture[14:] = (0, 0, -1) if kind == "normal" else value
        write_exr(folder / "ground_truth" / kind / f"{EXACT}.exr", picture)


@pytest.fixture(scope="session")
def uniform_oracle() -> float:
    """Display value of albedo 0.5 under uniform light of radiance 0.6: (0.5 * 0.6)^(1/2.2)."""
    return float((0.5 / pi * 0.6 * pi) ** (1 / 2.2))
