"""Training with an outdoor light: its losses by hand, and who moves sun and sky."""

from math import pi, sqrt

import pytest
import torch
from support.settings import train_settings

from r3gw.geometry.cameras import Camera
from r3gw.model.initial import InitialPoints
from r3gw.model.light_models.base import OpenSky
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.training.lights.outdoor import open_sky_loss
from r3gw.training.objective import objective
from r3gw.training.optimizer import adam_step, make_optimizer
from r3gw.training.photos import Photo
from r3gw.training.schedule import Schedule
from r3gw.training.settings import TrainSettings
from r3gw.training.start import initial_model
from r3gw.training.sun_shadows import SunShadows
from r3gw.training.visible_sky import visible_sky

WIDTH, HEIGHT = 32, 24


@pytest.fixture
def settings() -> TrainSettings:
    return train_settings(outdoor={"enabled": True, "visible_sky": 2.0, "sky_gradient": 0.5})


@pytest.fixture
def photo() -> Photo:
    """Display grey everywhere, upper half sky, seen level."""
    pose = torch.eye(4, dtype=torch.float64)
    camera = Camera(pose, (30.0, 30.0, WIDTH / 2, HEIGHT / 2), WIDTH, HEIGHT)
    planes = torch.full((3, HEIGHT, WIDTH), 128, dtype=torch.uint8)
    is_sky = torch.zeros(HEIGHT, WIDTH, dtype=torch.bool)
    is_sky[: HEIGHT // 2] = True
    return Photo("a", camera, planes, ~is_sky | is_sky, is_sky, visible_sky(camera, planes, is_sky))


def test_the_sky_pays_for_its_colour_and_for_changes_of_its_gradient(settings, photo):
    """An even sky of 0.5 before grey of (128/255)**2.2, its change 0.1 in all of bands 0 and 1."""
    radiance = torch.zeros(4, 3)
    radiance[0] = 0.5 * sqrt(4 * pi)
    change = torch.full((4, 3), 0.1)
    found = float(open_sky_loss(OpenSky(radiance, change), photo, settings.outdoor))
    colour = 3 * (0.5 - (128 / 255) ** 2.2) ** 2
    assert found == pytest.approx(2.0 * colour + 0.5 * 9 * 0.1**2, rel=1e-4)


def test_one_step_moves_sun_and_sky_at_their_rates(settings, photo):
    """Adam's first step is the learning rate; the first sky itself stays."""
    generator = torch.Generator().manual_seed(0)
    points = torch.rand(60, 3, generator=generator) * torch.tensor([6.0, 2.4, 0.2])
    dome = SkyDome(torch.tensor([0.0, 0.5, 0.0]), 8.0, (-1.0, 1.0))
    initial = InitialPoints(
        points + torch.tensor([-3.0, -0.5, 4.0]), dome, sample_dome(dome, 80, generator)
    )
    model = initial_model(initial, ("a",), settings)
    outdoor = model.appearance.light_model
    before = {name: value.clone() for name, value in outdoor.state_dict().items()}
    bias = model.appearance.light_head[-1].bias
    bias_before = bias.detach().clone()
    optimizer = make_optimizer(model, settings)
    schedule = Schedule.of(settings)
    last = schedule.iterations
    _, loss, parts = objective(model, settings, photo, 0, last, schedule, generator, SunShadows())
    loss.backward()
    adam_step(optimizer)
    assert parts["light"] > 0
    after = outdoor.state_dict()
    torch.testing.assert_close(after["first_skies"], before["first_skies"], rtol=0, atol=0)
    rate = settings.outdoor.sun_rate * settings.rates.short_run_boost
    moved = (after["log_sun_powers"] - before["log_sun_powers"]).abs()
    torch.testing.assert_close(moved, torch.full_like(moved, rate), rtol=1e-3, atol=0)
    # A step along the vector would not turn the sun: only its two horizontal parts move.
    turned = (after["sun_directions"] - before["sun_directions"]).abs()[:, [0, 2]]
    torch.testing.assert_close(turned, torch.full_like(turned, rate), rtol=1e-3, atol=0)
    sky = (bias.detach() - bias_before).abs()
    mlp_rate = settings.rates.mlp * settings.rates.short_run_boost
    torch.testing.assert_close(sky, torch.full_like(sky, mlp_rate), rtol=1e-3, atol=0)
