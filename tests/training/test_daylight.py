"""Daylight: its skies are as bright as photos show them, and its parts add up to a known light."""

from math import pi

import pytest
import torch
from support.settings import train_settings

from r3gw.geometry.cameras import Camera
from r3gw.imaging.colour import display_from_linear
from r3gw.lighting import envmap, sh
from r3gw.lighting.cie_sky import skies
from r3gw.model.light_models.base import DaySky
from r3gw.model.light_models.daylight import Daylight
from r3gw.training.lights.daylight import DaylightTraining, day_sky_loss, first_daylight
from r3gw.training.photos import Photo
from r3gw.training.visible_sky import visible_sky

SUN = torch.nn.functional.normalize(torch.tensor([0.4, -0.5, -0.77]), dim=0)
# Haze is white, and as bright as air is in the mean over channels.
CLEAR = torch.tensor([[0.10, 0.16, 0.31], [0.19, 0.19, 0.19], [0.0, 0.0, 0.0]])
COVERED = torch.tensor([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.20, 0.20, 0.21]])


def photo_of(colours: torch.Tensor) -> Photo:
    """A picture of the sky alone, away from the sun and a little upwards."""
    camera = Camera.looking_at([0.0, -3.0, 10.0], position=[0.0, 0.0, 0.0], width=40, height=30)
    rays = torch.stack(
        torch.meshgrid(torch.arange(30) + 0.5, torch.arange(40) + 0.5, indexing="ij"), dim=-1
    )
    fx, fy, cx, cy = camera.intrinsics
    looks = torch.stack(
        [(rays[..., 1] - cx) / fx, (rays[..., 0] - cy) / fy, torch.ones(30, 40)], dim=-1
    )
    looks = torch.nn.functional.normalize(looks, dim=-1) @ camera.cam_from_world[:3, :3].float()
    shown = skies(looks.reshape(-1, 3), SUN).T @ colours
    planes = (255 * display_from_linear(shown)).round().to(torch.uint8).T.reshape(3, 30, 40)
    everywhere = torch.ones(30, 40, dtype=torch.bool)
    sky = visible_sky(camera, planes, everywhere)
    return Photo("sky", camera, planes, everywhere, everywhere, sky)


def renewed(colours: torch.Tensor) -> Daylight:
    seen = [[photo_of(colours).seen_sky]]
    light = first_daylight(train_settings(), seen)
    with torch.no_grad():
        light.sun_directions[0] = 3.0 * SUN  # of any length
    DaylightTraining().renew(light, seen)
    return light


@pytest.mark.parametrize("colours", [CLEAR, COVERED])
def test_skies_are_found_again_from_photos_of_their_dark_side(colours):
    light = renewed(colours)
    torch.testing.assert_close(light.sky_suns[0], SUN, rtol=0, atol=1e-6)
    torch.testing.assert_close(light.sky_colours[0], colours, rtol=0.1, atol=0.01)


def test_a_sky_that_its_photo_shows_costs_nothing():
    settings = train_settings().outdoor
    photo, nothing = photo_of(CLEAR), torch.zeros(4, 3)
    right = float(day_sky_loss(DaySky(CLEAR, SUN, nothing), photo, settings))
    twice = float(day_sky_loss(DaySky(2 * CLEAR, SUN, nothing), photo, settings))
    assert right < 1e-4
    seen = skies(torch.stack([torch.tensor([0.0, -0.29, 0.957])]), SUN).T @ CLEAR
    assert twice == pytest.approx(float(seen.square().sum()), rel=0.3, abs=0)
    gradient = torch.zeros(4, 3)
    gradient[3] = 0.5
    without = Photo("none", photo.camera, photo.planes, photo.is_valid, photo.is_sky)
    alone = float(day_sky_loss(DaySky(CLEAR, SUN, gradient), without, settings))
    assert alone == pytest.approx(settings.sky_gradient * 3 * 0.25, rel=1e-5, abs=0)


def test_its_light_is_the_sum_of_its_parts():
    """Against a map that is painted part by part and projected."""
    light = renewed(CLEAR)
    with torch.no_grad():
        light.log_sun_powers[0] = torch.tensor([1.5, 1.2, 0.9]).log()
        found = light.environment(0, 0, torch.zeros(4, 3), torch.tensor(1.3))
    looks = envmap.pixel_directions(64, 128).float()
    sky = (skies(looks.reshape(-1, 3), SUN).T @ light.sky_colours[0]).reshape(64, 128, 3)
    is_up = (looks[..., 1] < 0)[..., None]
    weights = envmap.projection_weights(looks.double(), 0)[..., 0] * (4 * pi) ** 0.5
    level = (sky * (is_up[..., 0] * weights * -looks[..., 1])[..., None]).sum((0, 1))
    power = torch.tensor([1.5, 1.2, 0.9])
    ground = 0.2 / pi * (level + power * float(-SUN[1]))
    painted = torch.where(is_up, sky.double(), ground.double())
    expected = envmap.project(painted, looks.double(), 4)
    assert found.sun is not None
    torch.testing.assert_close(found.sun.irradiance, 1.3 * power, rtol=1e-5, atol=0)
    rest = found.light - found.sun.sh(4)
    torch.testing.assert_close(rest, 1.3 * expected, rtol=0.02, atol=0.02)


def test_an_unseen_sky_is_as_bright_as_the_first_light():
    """The mean over the upper half, of a light without a sun over ground that reflects nothing."""
    settings = train_settings(init={"light_radiance": 0.8}, outdoor={"ground_reflectance": 0.0})
    light = first_daylight(settings, [[]])
    with torch.no_grad():
        light.log_sun_powers.fill_(-20.0)
        made = light.environment(0, 0, torch.zeros(4, 3), None).light
    torch.testing.assert_close(made[0], sh.constant(0.8, 4)[0] / 2, rtol=2e-3, atol=0)
