"""Random scenes, and one way to run a rasterizer on them forward and backward."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import pytest
import torch
from torch import Tensor

from r3gw.raster import RasterResult, reference

PARAMETERS = ("means", "quaternions", "scales", "opacities", "features", "background")


@dataclass(frozen=True)
class RandomScene:
    """Inputs of `rasterize` and an image gradient, all drawn from one seed; float32."""

    means: Tensor
    quaternions: Tensor
    scales: Tensor
    opacities: Tensor
    features: Tensor
    background: Tensor
    cam_from_world: Tensor
    intrinsics: tuple[float, float, float, float]
    width: int
    height: int
    features_weight: Tensor
    alpha_weight: Tensor

    def run(self, rasterizer, dtype=torch.float32, **options):
        """Return the result and, by name, the gradients of the weighted sum of its images."""
        inputs = {
            name: getattr(self, name).to(dtype, copy=True).requires_grad_() for name in PARAMETERS
        }
        background = inputs["background"]
        pulls2d = torch.zeros(len(self.means), 2, dtype=dtype, requires_grad=True)
        result: RasterResult = rasterizer(
            *[inputs[name] for name in PARAMETERS[:-1]],
            self.cam_from_world.to(dtype),
            self.intrinsics,
            self.width,
            self.height,
            background,
            pulls2d=pulls2d,
            **options,
        )
        loss = (result.features * self.features_weight).sum()
        (loss + (result.alpha * self.alpha_weight).sum()).backward()
        gradients = {name: tensor.grad for name, tensor in inputs.items()}
        screen = {"means2d": result.means2d.grad, "pulls2d": pulls2d.grad}
        return result, gradients | screen

    def without_cutoffs(self, monkeypatch) -> "RandomScene":
        """The same with no image gradient at pixels where a hair's breadth changes what is drawn.

        There float32 and float64 may rightly disagree: an alpha at 1/255 is drawn or is not.
        """
        images = []
        for factor in (1 - 1e-4, 1 + 1e-4):
            with monkeypatch.context() as patch:
                patch.setattr(reference, "MIN_ALPHA", factor / 255)
                patch.setattr(reference, "MIN_TRANSMITTANCE", factor * 1e-4)
                result, _ = self.run(reference.rasterize, torch.float64)
            images.append(torch.cat([result.features, result.alpha[..., None]], dim=-1).detach())
        is_stable = ((images[0] - images[1]).abs() < 1e-9).all(-1)
        return replace(
            self,
            features_weight=self.features_weight * is_stable[..., None],
            alpha_weight=self.alpha_weight * is_stable,
        )


def _make_scene(
    seed: int = 0,
    count: int = 60,
    channels: int = 3,
    width: int = 37,
    height: int = 29,
    scale: float = 0.15,
    opacity: float = 0.0,
) -> RandomScene:
    generator = torch.Generator().manual_seed(seed)

    def normal(*shape: int) -> Tensor:
        return torch.randn(*shape, generator=generator)

    box = torch.tensor([3.0, 2.0, 4.0]), torch.tensor([-1.5, -1.0, 0.0])
    angle = 0.3 * float(normal(1))
    cos, sin = math.cos(angle), math.sin(angle)
    return RandomScene(
        means=torch.rand(count, 3, generator=generator) * box[0] + box[1],
        quaternions=normal(count, 4),
        scales=torch.exp(0.6 * normal(count, 3)) * scale,
        opacities=torch.sigmoid(1.5 * normal(count) + opacity),
        features=normal(count, channels),
        background=normal(channels),
        cam_from_world=torch.tensor([[cos, 0, sin, 0.1], [0, 1, 0, 0.05], [-sin, 0, cos, 0.3]]),
        intrinsics=(0.9 * width, 1.0 * width, 0.55 * width, 0.45 * height),
        width=width,
        height=height,
        features_weight=normal(height, width, channels),
        alpha_weight=normal(height, width),
    )


@pytest.fixture(scope="session")
def make_scene() -> Callable[..., RandomScene]:
    return _make_scene
