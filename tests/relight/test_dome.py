"""r3gw.relight.dome: spheres that are known, and rays from inside them."""

from math import pi

import pytest
import torch

from r3gw.geometry.spherical import direction_from_angles
from r3gw.relight.dome import Dome, dome_through

CENTRE, RADIUS = torch.tensor([3.0, -2.0, 40.0]), 7.5


def cap(count: int = 200, width_rad: float = 0.6) -> torch.Tensor:
    """Points of the sphere within a narrow range of azimuths, as a narrow view leaves them."""
    random = torch.Generator().manual_seed(0)
    theta = torch.rand(count, generator=random) * pi / 2
    phi = 1.0 + width_rad * torch.rand(count, generator=random)
    return CENTRE + RADIUS * direction_from_angles(theta, phi)


def test_the_sphere_through_a_part_of_it():
    dome = dome_through(cap())
    torch.testing.assert_close(dome.centre, CENTRE, rtol=0, atol=1e-4)
    assert dome.radius == pytest.approx(RADIUS, rel=1e-5)


@pytest.mark.parametrize(
    "points",
    [
        cap()[:10],
        torch.randn(200, 3, generator=torch.Generator().manual_seed(1)),
        torch.zeros(50, 3),
        torch.tensor([[1.0, 2.0, 3.0]]).repeat(50, 1) * torch.arange(50)[:, None],
    ],
)
def test_points_on_no_sphere_have_no_dome(points):
    assert dome_through(points) is None


def test_rays_leave_where_they_meet_the_sphere():
    dome = Dome(CENTRE, RADIUS)
    origin = CENTRE.double() + torch.tensor([2.0, 1.0, -3.0])
    directions = torch.nn.functional.normalize(
        torch.randn(50, 3, generator=torch.Generator().manual_seed(2)), dim=-1
    )
    ends = dome.exits(origin, directions)
    torch.testing.assert_close((ends - CENTRE).norm(dim=-1), torch.full((50,), RADIUS))
    along = torch.nn.functional.normalize(ends - origin.float(), dim=-1)
    torch.testing.assert_close(along, directions, rtol=0, atol=1e-5)
    assert dome.exits(CENTRE + 8.0, directions) is None
