"""A small model before a camera: fixtures for the tests of model, rendering and training."""

import pytest
import torch

from r3gw.geometry.cameras import Camera
from r3gw.model.initial import InitialPoints
from r3gw.model.model import SceneModel
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.training.settings import TrainSettings
from r3gw.training.start import initial_model
from support.settings import train_settings


@pytest.fixture
def settings() -> TrainSettings:
    """The paper's settings."""
    return train_settings()


@pytest.fixture
def model(settings: TrainSettings) -> SceneModel:
    """`small_model` with the paper's settings."""
    return small_model(settings)


def small_model(settings: TrainSettings) -> SceneModel:
    """Sixty random foreground Gaussians at z about 4, eighty sky Gaussians, two photos."""
    generator = torch.Generator().manual_seed(0)
    points = torch.randn(60, 3, generator=generator) + torch.tensor([0.0, 0.0, 4.0])
    dome = SkyDome(torch.tensor([0.0, 0.0, 4.0]), 9.0, (-1.5, 1.5))
    made = initial_model(
        InitialPoints(points, dome, sample_dome(dome, 80, generator)), ("a", "b"), settings
    )
    with torch.no_grad():
        for rows in (made.foreground, made.sky.rows):
            for value in rows.values.values():
                value.add_(0.2 * torch.randn(value.shape, generator=generator))
    made.sky.clamp_to_dome()
    return made


@pytest.fixture
def camera() -> Camera:
    """At the origin, looking along +z; not square, principal point off-centre."""
    return Camera(torch.eye(4, dtype=torch.float64), (40.0, 42.0, 25.0, 18.0), 48, 36)
