"""Which cameras see which points."""

from dataclasses import replace

import numpy as np
import torch

from r3gw.geometry.cameras import Camera
from r3gw.relight.gaussians import Relightable
from r3gw.view.coverage import coverage
from r3gw.view.seen import seen_bits


def wall(z: float) -> torch.Tensor:
    """Positions of a wall of Gaussians across the z axis."""
    steps = torch.linspace(-1, 1, 21)
    x, y = torch.meshgrid(steps, steps, indexing="ij")
    return torch.stack([x.flatten(), y.flatten(), torch.full((441,), z)], dim=-1)


def scene(means: torch.Tensor) -> Relightable:
    """Opaque discs that face along z."""
    count = len(means)
    return Relightable(
        means,
        torch.tensor([[1.0, 0.0, 0.0, 0.0]]).repeat(count, 1),
        torch.tensor([[0.08, 0.08, 1e-4]]).log().repeat(count, 1),
        torch.full((count,), 6.0),
        torch.full((count, 3), 0.5),
        torch.full((count,), 0.5),
        {},
        4,
        True,
    )


def camera(z: float, turn: float) -> Camera:
    """On the z axis, looking along +z (``turn`` 1) or back along it (-1)."""
    pose = torch.diag(torch.tensor([turn, 1.0, turn, 1.0], dtype=torch.float64))
    pose[2, 3] = -turn * z
    return Camera(pose, (100.0, 100.0, 50.0, 50.0), 100, 100)


def test_a_wall_hides_what_is_behind_it():
    two = scene(torch.cat([wall(4.0), wall(6.0)]))
    found = coverage(two, [camera(0.0, 1.0), camera(10.0, -1.0)])
    for point, seen in zip(found["points"], found["seenBy"], strict=True):
        assert seen == ([0] if point[2] == 4.0 else [1])


def test_normals_point_to_the_cameras_that_see_the_surface():
    two = scene(torch.cat([wall(4.0), wall(6.0)]))
    found = coverage(two, [camera(0.0, 1.0), camera(10.0, -1.0)])
    z = np.array(found["normals"])[:, 2]
    is_near = np.array(found["points"])[:, 2] == 4.0
    np.testing.assert_array_equal(z[is_near], -1.0)
    np.testing.assert_array_equal(z[~is_near], 1.0)


def test_outside_a_picture_nothing_is_seen():
    aside = scene(wall(4.0) + torch.tensor([20.0, 0.0, 0.0]))
    assert all(seen == [] for seen in coverage(aside, [camera(0.0, 1.0)])["seenBy"])


def test_without_cameras_or_surfaces_there_is_nothing_to_say():
    one = scene(wall(4.0))
    assert coverage(one, []) is None
    bare = replace(one, albedo=one.albedo[:0], roughness=one.roughness[:0])
    assert coverage(bare, [camera(0.0, 1.0)]) is None


def test_bits_of_a_texture_say_which_photos_see_a_gaussian():
    """Of two walls behind each other, a camera on either side sees its own."""
    gaussians = scene(torch.cat([wall(-1.0), wall(1.0)]))
    front = Camera.looking_at((0.0, 0.0, 0.0), position=(0.0, 0.0, -6.0), width=96, height=96)
    back = Camera.looking_at((0.0, 0.0, 0.0), position=(0.0, 0.0, 6.0), width=96, height=96)
    asked, bits = seen_bits(gaussians, [front, back], rows=1)
    assert asked == [0, 1]
    assert bits.shape == (2048,)
    assert (bits[:441] == 1).mean() > 0.9
    assert (bits[441:882] == 2).mean() > 0.9
    assert (bits[882:] == 0).all()
