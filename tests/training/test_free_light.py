"""Eq. 12 as training draws it: where it looks and what it averages over."""

from math import pi, sqrt

import pytest
import torch
from support.settings import train_settings

from r3gw.geometry.cameras import Camera
from r3gw.model.appearance import PhotoLight
from r3gw.training.lights.free import FreeTraining
from r3gw.training.losses.weighted import value_of
from r3gw.training.photos import Photo

CAMERA = Camera(torch.eye(4, dtype=torch.float64), (4.0, 4.0, 2.0, 2.0), 4, 4)
EMPTY = torch.zeros(4, 4, dtype=torch.bool)
PHOTO = Photo("any", CAMERA, torch.zeros(3, 4, 4, dtype=torch.uint8), EMPTY, EMPTY)
Y1 = 0.48860251  # of sh.basis, band 1


def loss_of(light: torch.Tensor, **weights) -> float:
    """The loss of one light with very many directions, unweighted."""
    settings = train_settings(weights={"light": 1.0, "light_directions": 100_000, **weights})
    generator = torch.Generator().manual_seed(3)
    lit = PhotoLight(light, torch.zeros(4, 3), None)
    (named,) = FreeTraining().losses(lit, PHOTO, settings, generator)
    return float(value_of(named.loss))


def dark_below() -> torch.Tensor:
    """L = height above the horizon in every channel: negative below it, down to -1."""
    light = torch.zeros(25, 3)
    light[1] = -1 / Y1  # up is -y
    return light


def test_the_upper_hemisphere_does_not_see_a_light_that_is_negative_below():
    assert loss_of(dark_below(), light_domain="hemisphere") == 0.0


def test_the_sphere_sees_it():
    """The mean of min(0, h)^2 over the sphere is 1/6, times three channels."""
    assert loss_of(dark_below(), light_domain="sphere") == pytest.approx(0.5, abs=5e-3)


def test_the_average_over_negative_radiances_is_that_of_their_squares():
    """Mean of h^2 over the lower half: 1/3; a channel that is never negative does not count."""
    light = dark_below()
    assert loss_of(light, light_domain="sphere", light_average="negative") == pytest.approx(
        1 / 3, abs=5e-3
    )
    light[:, 0] = 0.0
    light[0, 0] = sqrt(4 * pi)
    assert loss_of(light, light_domain="sphere", light_average="negative") == pytest.approx(
        1 / 3, abs=5e-3
    )


def test_the_average_over_none_is_nothing():
    light = torch.zeros(25, 3)
    light[0] = sqrt(4 * pi)
    assert loss_of(light, light_domain="sphere", light_average="negative") == 0.0
