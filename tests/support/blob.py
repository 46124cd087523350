"""A scene that is hard to draw: random Gaussians with shadows, tilted cameras, a learned sky."""

from math import pi
from pathlib import Path

import numpy as np
import torch
from scipy.spatial.transform import Rotation

from r3gw.geometry.similarity import Similarity
from r3gw.imaging.files import write_image
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.relight.gaussians import Relightable
from r3gw.scene import Scene, View, save_scene
from r3gw.scene.scene import Gauge

NUM_FOREGROUND, NUM_SKY = 1500, 300
SIZE = (160, 120)
VIEWS = tuple(f"v_{i}" for i in range(5))
PHOTOS = VIEWS[:4]


def blob_gaussians() -> Relightable:
    """A blob of thin Gaussians at z = 6 before a half-dome of sky."""
    random = torch.Generator().manual_seed(3)

    def normal(*shape: int) -> torch.Tensor:
        return torch.randn(*shape, generator=random)

    count = NUM_FOREGROUND + NUM_SKY
    means = normal(count, 3) * torch.tensor([1.5, 1.0, 1.0]) + torch.tensor([0.0, 0.0, 6.0])
    theta = torch.rand(NUM_SKY, generator=random) * pi / 2
    phi = (torch.rand(NUM_SKY, generator=random) - 0.5) * pi
    ring = [theta.sin() * phi.sin(), -theta.cos(), theta.sin() * phi.cos()]
    means[NUM_FOREGROUND:] = 20 * torch.stack(ring, dim=-1)
    log_scales = normal(count, 3) * 0.5 - 2.2
    log_scales[:, 1] -= 4.0  # flat along their second axis
    log_scales[NUM_FOREGROUND:] += 2.0
    lights = {
        name: Light(
            0.25 * normal(25, 3) + torch.tensor([[2.5]] + 24 * [[0.0]]),
            LearnedSky(0.15 * normal(4, 3)),
        )
        for name in PHOTOS
    }
    return Relightable(
        means,
        normal(count, 4),
        log_scales,
        normal(count) * 1.5 + 0.5,
        torch.rand(NUM_FOREGROUND, 3, generator=random),
        torch.rand(NUM_FOREGROUND, generator=random),
        lights,
        4,
        True,
        -0.05 * torch.rand(NUM_FOREGROUND, 25, generator=random),
    )


def write_blob_scene(folder: Path) -> None:
    """Five cameras with different lenses, off-centre and tilted; four are training photos."""
    save_scene(
        Scene(
            name="blob <&> co",
            source_format="synthetic",
            views=tuple(_view(i, name) for i, name in enumerate(VIEWS)),
            scene_from_source=Gauge.of(Similarity.identity()),
        ),
        folder,
    )
    pixels = np.random.default_rng(0).integers(0, 255, (*SIZE[::-1], 3), np.uint8)
    for name in VIEWS[:-1]:  # the picture of the last is missing
        write_image(folder / "images" / f"{name}.png", pixels)


def _view(number: int, name: str) -> View:
    turn = Rotation.from_euler("yxz", [12 * (number - 2), 5 * number - 8, 9 * number], degrees=True)
    cam_from_world = np.eye(4)
    cam_from_world[:3, :3] = turn.as_matrix()
    cam_from_world[:3, 3] = turn.as_matrix() @ np.array([0.0, 0.0, -6.0]) + [0, 0, 6 - number / 2]
    focal = 110.0 + 15 * number
    return View(
        name=name,
        image=f"images/{name}.png",
        width=SIZE[0],
        height=SIZE[1],
        intrinsics=(focal, 1.05 * focal, 80.0 + 6 * number, 60.0 - 4 * number),
        cam_from_world=tuple(tuple(row) for row in cam_from_world.tolist()),
        split="train" if name in PHOTOS else "test",
        session=None,
    )
