"""What photos show of the sky: which way, how bright, and what a session's first sky is made of."""

from dataclasses import replace
from math import pi, sqrt

import pytest
import torch

from r3gw.geometry.cameras import Camera
from r3gw.lighting import sh
from r3gw.training.visible_sky import VisibleSky, first_sky, visible_sky

WIDTH, HEIGHT, FOCAL = 40, 30, 30.0


def upright(yaw_rad: float = 0.0) -> Camera:
    """A camera at the origin that looks level, turned from +z towards +x."""
    turn = torch.tensor(yaw_rad, dtype=torch.float64)
    pose = torch.eye(4, dtype=torch.float64)
    pose[0, 0], pose[0, 2] = torch.cos(turn), -torch.sin(turn)
    pose[2, 0], pose[2, 2] = torch.sin(turn), torch.cos(turn)
    return Camera(pose, (FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2), WIDTH, HEIGHT)


def upper_half() -> torch.Tensor:
    """A mask of sky above the middle row."""
    is_sky = torch.zeros(HEIGHT, WIDTH, dtype=torch.bool)
    is_sky[: HEIGHT // 2] = True
    return is_sky


def directions_of(seen: VisibleSky) -> torch.Tensor:
    """Back from band 1, which is sqrt(3 / 4 pi) (y, z, x)."""
    return seen.basis[:, [3, 1, 2]] / sqrt(3 / (4 * pi))


def test_directions_and_values_of_sky_pixels():
    """Rows hold their own value, so that each sample's height tells which row it is of."""
    values = (4 * torch.arange(HEIGHT, dtype=torch.uint8))[:, None].expand(HEIGHT, WIDTH)
    seen = visible_sky(upright(), values.expand(3, -1, -1), upper_half())
    directions = directions_of(seen)
    assert len(directions) == 256
    torch.testing.assert_close(directions.norm(dim=-1), torch.ones(256), rtol=1e-6, atol=0)
    torch.testing.assert_close(seen.heights, -directions[:, 1], rtol=1e-6, atol=1e-7)
    row = HEIGHT / 2 + FOCAL * directions[:, 1] / directions[:, 2] - 0.5
    expected = (4 * row.round() / 255) ** 2.2
    torch.testing.assert_close(seen.radiance, expected[:, None].expand(-1, 3), rtol=1e-4, atol=1e-6)
    assert float((row - row.round()).abs().max()) < 1e-3
    assert float(row.min()) < 0.5
    assert float(row.max()) > HEIGHT / 2 - 1.5
    assert not bool(seen.is_clipped.any())


def test_a_turned_camera_sees_what_lies_there():
    """Turned by 90 degrees towards +x, the middle of the picture shows +x."""
    planes = torch.full((3, HEIGHT, WIDTH), 255, dtype=torch.uint8)
    seen = visible_sky(upright(pi / 2), planes, upper_half())
    middle = directions_of(seen).mean(0)
    assert float(middle[0]) > 0.8
    assert abs(float(middle[2])) < 0.02
    assert bool(seen.is_clipped.all())


def test_a_photo_with_hardly_any_sky_tells_nothing():
    is_sky = torch.zeros(HEIGHT, WIDTH, dtype=torch.bool)
    is_sky[:4] = True  # 160 pixels
    assert visible_sky(upright(), torch.zeros(3, HEIGHT, WIDTH, dtype=torch.uint8), is_sky) is None


def sky_of(colour: tuple[float, float, float]) -> VisibleSky:
    """Everywhere the same colour."""
    planes = torch.zeros(3, HEIGHT, WIDTH, dtype=torch.uint8)
    seen = visible_sky(upright(), planes, upper_half())
    radiance = torch.tensor(colour).expand(256, 3)
    return replace(seen, radiance=radiance)


@pytest.mark.parametrize(("red", "zenith"), [(0.2, 1.0), (0.45, 2.0), (0.325, 1.5)])
def test_grey_skies_are_brighter_above(red, zenith):
    """Blue: even. Grey: twice the horizon at the zenith. Between: between; seen colour is kept."""
    seen = sky_of((red, 0.5, 0.5))
    sky = first_sky([seen], 0.8)
    up, level = sh.radiance(sky, torch.tensor([[0.0, -1.0, 0.0], [0.6, 0.0, 0.8]]))
    torch.testing.assert_close(up, zenith * level, rtol=1e-5, atol=0)
    shown = (seen.basis @ sky).mean(0)
    torch.testing.assert_close(shown, torch.tensor([red, 0.5, 0.5]), rtol=1e-5, atol=0)


def test_an_unseen_sky_is_even():
    sky = first_sky([], 0.8)
    torch.testing.assert_close(sky[0], torch.full((3,), 0.8 * sqrt(4 * pi)), rtol=1e-6, atol=0)
    assert float(sky[1:].abs().max()) == 0.0
