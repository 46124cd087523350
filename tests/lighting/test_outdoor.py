"""Sun, sky and ground against closed forms and against an environment map of the same."""

from math import pi, sqrt

import pytest
import torch

from r3gw.lighting import envmap, sh
from r3gw.lighting.irradiance import irradiance
from r3gw.lighting.outdoor import basis_of_one, outdoor_light

UP = torch.tensor([0.0, -1.0, 0.0])
GREY = torch.tensor([1.0, 1.0, 1.0])


def even_sky(radiance: float) -> torch.Tensor:
    """SH coefficients of the same radiance everywhere."""
    sky = torch.zeros(4, 3)
    sky[0] = radiance * sqrt(4 * pi)
    return sky


def test_even_sky_over_white_ground_is_the_same_everywhere() -> None:
    """Matt ground that reflects all is as bright as the even sky above it."""
    light = outdoor_light(even_sky(0.7), UP, 0 * GREY, 1.0, 4)
    torch.testing.assert_close(light[0], 0.7 * sqrt(4 * pi) * GREY, rtol=2e-4, atol=0)
    torch.testing.assert_close(light[1:], torch.zeros(24, 3), rtol=0, atol=2e-4)


def test_sun_alone_peaks_where_it_stands_and_lights_the_ground_by_its_height() -> None:
    """A point of power P: coefficients P Y(sun), plus ground of radiance rho P cos / pi."""
    sun = torch.nn.functional.normalize(torch.tensor([0.6, -0.7, 0.2]), dim=0)
    power = torch.tensor([3.0, 2.0, 1.0])
    bare = outdoor_light(even_sky(0.0), sun, power, 0.0, 4)
    torch.testing.assert_close(bare, sh.basis(sun, 4)[:, None] * power, rtol=1e-6, atol=1e-6)
    lit = outdoor_light(even_sky(0.0), sun, power, 0.3, 4) - bare
    mean = lit[0] / sqrt(4 * pi)  # the ground fills half the sphere
    torch.testing.assert_close(mean, 0.3 / pi * power * -sun[1] / 2, rtol=1e-3, atol=0)


def test_sun_below_the_horizon_lights_no_ground() -> None:
    """Its own coefficients stay; the ground's do not go negative."""
    light = outdoor_light(even_sky(0.0), -UP, 2 * GREY, 0.5, 2)
    torch.testing.assert_close(light, sh.basis(-UP, 2)[:, None] * 2 * GREY, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("degree", [2, 4])
def test_agrees_with_the_map_of_the_same_sky(degree: int) -> None:
    """Drawn as an environment map and projected, sky and ground give the same coefficients."""
    generator = torch.Generator().manual_seed(1)
    sky = even_sky(1.0) + 0.3 * torch.randn(4, 3, generator=generator)
    directions = envmap.pixel_directions(64, 128).float()
    above = directions[..., 1:2] < 0
    radiance = sh.radiance(sky, directions)
    theta, _ = envmap.pixel_angles(64, 128)
    area = (torch.sin(theta) * 4 * pi / torch.sin(theta).sum()).float()
    cosine = (-directions[..., 1]).clamp_min(0)
    level = (radiance * (area * cosine)[..., None]).sum((0, 1))
    drawn = torch.where(above, radiance, 0.2 / pi * level)
    expected = envmap.project(drawn, directions.double(), degree)
    light = outdoor_light(sky, UP, 0 * GREY, 0.2, degree)
    torch.testing.assert_close(light, expected, rtol=0, atol=2e-3)


def test_level_ground_receives_what_an_even_sky_sends() -> None:
    """E = pi L under an even sky; bands 0 to 2 of the half-sphere carry it to 1 %."""
    light = outdoor_light(even_sky(0.5), UP, 0 * GREY, 0.0, 2)
    received = irradiance(light, UP[None])[0]
    torch.testing.assert_close(received, 0.5 * pi * GREY, rtol=0.01, atol=0)


@pytest.mark.parametrize("degree", [1, 2, 4])
def test_basis_of_one_vector_is_the_basis(degree: int) -> None:
    """Values, and the gradient along the sphere; across it both are free to differ."""
    generator = torch.Generator().manual_seed(3)
    for _ in range(20):
        vector = torch.randn(3, generator=generator).requires_grad_()
        found, expected = (
            basis(torch.nn.functional.normalize(vector, dim=0), degree)
            for basis in (basis_of_one, sh.basis)
        )
        torch.testing.assert_close(found, expected, rtol=0, atol=2e-6)
        pull = torch.randn(found.shape, generator=generator)
        ours, theirs = (
            torch.autograd.grad((pull * basis).sum(), vector, retain_graph=True)[0]
            for basis in (found, expected)
        )
        torch.testing.assert_close(ours, theirs, rtol=1e-4, atol=1e-4 * float(theirs.norm()))


def test_gradients_agree_with_finite_differences() -> None:
    """Of sky, sun direction and power, in double precision."""
    generator = torch.Generator().manual_seed(2)
    sky = torch.randn(4, 3, generator=generator, dtype=torch.float64, requires_grad=True)
    sun = torch.tensor([0.3, -0.9, 0.3], dtype=torch.float64, requires_grad=True)
    power = torch.rand(3, generator=generator, dtype=torch.float64, requires_grad=True)

    def light(*inputs: torch.Tensor) -> torch.Tensor:
        return outdoor_light(*inputs, 0.2, 4)

    assert torch.autograd.gradcheck(light, (sky, sun, power), atol=1e-6, rtol=1e-5)
