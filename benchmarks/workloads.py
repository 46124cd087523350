"""What the rasterizer's benchmark draws: seeded random Gaussians, and a trained scene."""

import math
from dataclasses import dataclass
from pathlib import Path

import torch

from r3gw.model.model_file import load_model
from r3gw.rendering.splats import splats_of
from r3gw.scene import load_scene

TRAINED = Path("results/chapel/full/seed0/model.safetensors")


@dataclass(frozen=True)
class Drawing:
    """Gaussians and the camera that sees them, as `r3gw.raster.rasterize` takes them."""

    means: torch.Tensor
    quaternions: torch.Tensor
    scales: torch.Tensor
    opacities: torch.Tensor
    features: torch.Tensor
    cam_from_world: torch.Tensor
    intrinsics: list[float]
    width: int
    height: int


@dataclass(frozen=True)
class Slab:
    """A seeded slab of Gaussians in front of an identity camera (docs/rasterizer.md)."""

    name: str
    gaussians: int
    width: int
    height: int
    opacity_shift: float = 0.5
    scale: float = 1.0
    with_reference: bool = False

    def drawing(self, channels: int) -> Drawing:
        """Draw the Gaussians; ``channels`` random features each."""
        n = self.gaussians
        torch.manual_seed(0)
        means = torch.rand(n, 3) * torch.tensor([8.0, 6.0, 4.0]) - torch.tensor([4.0, 3.0, -4.0])
        middle = math.log(self.scale * 0.06 * math.sqrt(20_000 / n))
        scales = torch.exp(torch.randn(n, 3) * 0.5 + middle)
        quaternions = torch.nn.functional.normalize(torch.randn(n, 4), dim=-1)
        opacities = torch.sigmoid(torch.randn(n) * 1.5 + self.opacity_shift)
        focal = 0.9 * self.width
        return Drawing(
            *(means, quaternions, scales, opacities, torch.rand(n, channels)),
            torch.eye(4),
            [focal, focal, self.width / 2, self.height / 2],
            self.width,
            self.height,
        )


@dataclass(frozen=True)
class Trained:
    """A trained embedded scene from its first training photo, enlarged to a picture's size."""

    name: str
    width: int
    height: int
    with_reference: bool = False

    def drawing(self, channels: int) -> Drawing:
        """Load the model; ``channels`` random features per Gaussian."""
        model = load_model(TRAINED)
        scene = load_scene(TRAINED.parents[2] / "scene")
        camera = scene.split("train")[0].camera.scaled(self.width, self.height)
        with torch.no_grad():
            splats = splats_of(model, camera, torch.zeros(9, 3), None)
        torch.manual_seed(0)
        return Drawing(
            *(splats.means, splats.quaternions, splats.scales, splats.opacities),
            torch.rand(len(splats.means), channels),
            camera.cam_from_world.float(),
            list(camera.intrinsics),
            self.width,
            self.height,
        )


def workloads() -> dict[str, Slab | Trained]:
    """By name; the trained scene only where `make all` has run."""
    found: list[Slab | Trained] = [
        Slab("tiny", 2_000, 80, 60, with_reference=True),
        Slab("slab-20k", 20_000, 320, 240),
        Slab("sparse-50k", 50_000, 640, 480, opacity_shift=-2.0, scale=0.4),
        Slab("slab-100k", 100_000, 640, 480),
        Slab("slab-200k", 200_000, 1024, 768),
    ]
    if TRAINED.exists():
        found.append(Trained("chapel", 640, 480))
    return {workload.name: workload for workload in found}
