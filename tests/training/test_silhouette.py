"""The silhouette in place of Eq. 15: the kernel's loss and gradients against the plain one."""

import pytest
import torch
from support.settings import train_settings

from r3gw.geometry.cameras import Camera
from r3gw.model.initial import InitialPoints
from r3gw.model.model import SceneModel
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.rendering.compose import draw
from r3gw.rendering.splats import splats_of
from r3gw.training.losses.separation import silhouette_loss
from r3gw.training.objective import objective
from r3gw.training.photos import Photo
from r3gw.training.schedule import Schedule
from r3gw.training.start import initial_model
from r3gw.training.sun_shadows import SunShadows

WIDTH, HEIGHT = 40, 30
WEIGHT, SOLID = 0.7, 0.3


SETTINGS = train_settings(
    silhouette={"enabled": True, "solid": SOLID},
    weights={"separation": WEIGHT},
    init={"opacity": 0.4},
)


@pytest.fixture
def model() -> SceneModel:
    """Half-transparent foreground before a dome, a silhouette instead of Eq. 15."""
    generator = torch.Generator().manual_seed(0)
    points = torch.randn(80, 3, generator=generator) + torch.tensor([0.0, 0.0, 4.0])
    dome = SkyDome(torch.tensor([0.0, 0.0, 4.0]), 9.0, (-1.5, 1.5))
    initial = InitialPoints(points, dome, sample_dome(dome, 60, generator))
    made = initial_model(initial, ("a",), SETTINGS)
    scales = made.foreground["log_scales"].data  # balls at first, which turning does not change
    scales += 0.5 * torch.randn(scales.shape, generator=generator)
    return made


@pytest.fixture
def photo() -> Photo:
    """Upper third sky, an occluder at the left of all."""
    pose = torch.eye(4, dtype=torch.float64)
    camera = Camera(pose, (30.0, 30.0, WIDTH / 2, HEIGHT / 2), WIDTH, HEIGHT)
    is_sky = torch.zeros(HEIGHT, WIDTH, dtype=torch.bool)
    is_sky[: HEIGHT // 3] = True
    is_valid = torch.ones_like(is_sky)
    is_valid[:, :7] = False
    planes = torch.full((3, HEIGHT, WIDTH), 128, dtype=torch.uint8)
    return Photo("a", camera, planes, is_valid, is_sky)


def separation(model: SceneModel, photo: Photo) -> tuple[torch.Tensor, float]:
    """The objective of the first iteration, in which nothing but the separation acts."""
    schedule = Schedule.of(SETTINGS)
    assert schedule.warm_up >= 1
    generator = torch.Generator().manual_seed(0)
    _, loss, parts = objective(model, SETTINGS, photo, 0, 1, schedule, generator, SunShadows())
    return loss, parts["silhouette"]


def plain(model: SceneModel, photo: Photo) -> torch.Tensor:
    """The foreground's opacity drawn as a colour, and `silhouette_loss` of it."""
    light, sky_light = model.appearance(0)[:2]
    splats = splats_of(model, photo.camera, light, sky_light)
    presence = torch.zeros(model.num_gaussians, 3)
    presence[: len(model.foreground)] = 1.0
    opacity = draw(splats.with_colours(presence), photo.camera).colour[..., 0]
    return WEIGHT * silhouette_loss(opacity, photo.is_sky, photo.is_valid, SOLID)


def test_its_value_is_the_plain_one(model, photo):
    expected = float(plain(model, photo).detach())
    assert 0.02 < expected < 0.7  # sky and foreground both count
    assert separation(model, photo)[1] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("name", ["opacity_logits", "means", "log_scales", "quaternions"])
def test_its_gradients_are_the_plain_ones(model, photo, name):
    value = model.foreground[name]
    (found,) = torch.autograd.grad(separation(model, photo)[0], value)
    (expected,) = torch.autograd.grad(plain(model, photo), value)
    size = float(expected.abs().max())
    assert size > 1e-6
    torch.testing.assert_close(found, expected, rtol=1e-3, atol=1e-4 * size)


def test_sky_behind_the_foreground_is_left_alone(model, photo):
    """No gradient reaches a sky Gaussian that hides no foreground; Eq. 15 thins them."""
    sky = model.sky.rows["opacity_logits"]
    (found,) = torch.autograd.grad(separation(model, photo)[0], sky)
    nearest_sky = 4.0
    model.foreground["means"].data[:, 2] = nearest_sky - 3.0
    (behind,) = torch.autograd.grad(separation(model, photo)[0], sky)
    assert float(found.abs().max()) > 0  # some hide foreground at first
    assert float(behind.abs().max()) == 0.0
