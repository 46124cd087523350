"""r3gw.relight.witnesses: photos speak for their own place, of what they saw past the surfaces."""

from dataclasses import replace

import pytest
import torch
from support.blob import NUM_FOREGROUND, blob_gaussians

from r3gw.geometry.cameras import Camera
from r3gw.relight.witnesses import Witnesses

WALL = (0.0, 0.0, 6.0)


def at(right: float = 0.0, back: float = 0.0, width: int = 96, height: int = 64) -> Camera:
    """A camera that looks along +z from near the origin; it sees the blob in the middle."""
    return Camera.looking_at(
        (right, 0.0, 6.0), position=(right, 0.0, -back), fov_deg=60.0, width=width, height=height
    )


@pytest.fixture(scope="module")
def opaque():
    """A small solid ball before a dome of radius 20."""
    gaussians = blob_gaussians()
    means = gaussians.means.clone()
    means[:NUM_FOREGROUND] = torch.tensor(WALL) + 0.3 * torch.randn(
        NUM_FOREGROUND, 3, generator=torch.Generator().manual_seed(0)
    )
    return replace(
        gaussians, means=means, opacity_logits=torch.full_like(gaussians.opacity_logits, 6.0)
    )


def test_a_photo_saw_what_its_foreground_leaves_free(opaque):
    """In its own picture and in other sizes of it: free beside the ball, nothing behind it."""
    photo = at()
    witnesses = Witnesses(opaque, [photo])
    for size in ((96, 64), (60, 80), (240, 160)):
        seen = witnesses.darkness(photo.scaled(*size))[..., 0]
        assert seen[0, 0] == 1
        assert seen[-1, -1] == 1
        assert seen[size[1] // 2, size[0] // 2] == 0
        assert 0.5 < seen.mean() < 1


def test_maps_hang_the_right_way_round(opaque):
    """The ball stands to the left of a photo that looks past it; a wider camera finds it there."""
    photo = Camera.looking_at((2.0, 1.0, 6.0), position=(0.0, 0.0, 0.0), width=96, height=64)
    fx, fy, cx, cy = photo.intrinsics
    wide = Camera(photo.cam_from_world, (fx / 2, fy / 2, cx, cy), 96, 64)
    seen = Witnesses(opaque, [photo]).darkness(wide)[..., 0]
    inside = torch.zeros_like(seen, dtype=torch.bool)
    inside[16:48, 24:72] = True  # the photo's frame in the wider picture
    assert (seen[~inside] == 0).all()
    own = Witnesses(opaque, [photo]).darkness(photo.scaled(48, 32))[..., 0]
    torch.testing.assert_close(seen[17:47, 25:71], own[1:-1, 1:-1], rtol=0, atol=0.15)
    ball = (own < 0.5).nonzero().float().mean(dim=0)
    assert ball[0] < 16
    assert ball[1] < 24


def test_photos_speak_less_from_further_away(opaque):
    reach = 0.6  # a tenth of the 6 units to the ball
    witnesses = Witnesses(opaque, [at(), at(right=3.0)])
    assert witnesses.reaches()[0] == pytest.approx(reach, rel=0.02)
    assert [near.number for near in witnesses.near(at())] == [0]
    half = witnesses.near(at(right=reach / 2))[0].weight
    assert half == pytest.approx(0.75**2, abs=0.02)
    assert witnesses.near(at(back=0.7)) == []
    assert (witnesses.darkness(at(back=0.7)) == 0).all()
    between = witnesses.darkness(at(right=reach / 2))
    assert between.max() == pytest.approx(half, abs=1e-6)


def test_the_surest_four_are_asked(opaque):
    cameras = [at(right=0.05 * i) for i in range(7)]
    near = Witnesses(opaque, cameras).near(at(right=0.1))
    assert near[0].number == 2
    assert {each.number for each in near} <= {0, 1, 2, 3, 4}
    assert len(near) == 4


def test_without_a_dome_what_is_behind_is_far_away(opaque):
    """Models of one set, and cameras outside of the dome."""
    one_set = replace(
        opaque,
        means=opaque.means[:NUM_FOREGROUND],
        quaternions=opaque.quaternions[:NUM_FOREGROUND],
        log_scales=opaque.log_scales[:NUM_FOREGROUND],
        opacity_logits=opaque.opacity_logits[:NUM_FOREGROUND],
    )
    assert one_set.dome is None
    seen = Witnesses(one_set, [at()]).darkness(at())[..., 0]
    assert seen[0, 0] == 1
    assert seen[32, 48] == 0


def test_without_photos_or_surfaces_nobody_speaks(opaque):
    assert (Witnesses(opaque, []).darkness(at()) == 0).all()
    no_surfaces = replace(
        opaque, albedo=opaque.albedo[:0], roughness=opaque.roughness[:0], occlusion=None
    )
    assert Witnesses(no_surfaces, [at()]).near(at()) == []
