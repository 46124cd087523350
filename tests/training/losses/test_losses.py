"""Each loss against closed forms on hand-made inputs, and where its gradient goes."""

from math import exp, pi, sqrt

import pytest
import torch
from support.settings import train_settings

from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.geometry.spherical import direction_from_angles
from r3gw.lighting import sh
from r3gw.training.losses.geometry import (
    flatness_loss,
    given_normal_loss,
    normal_loss,
    normals_from_depth,
)
from r3gw.training.losses.lighting import positivity_loss, random_directions, visible_sky_loss
from r3gw.training.losses.reconstruction import masked_l1
from r3gw.training.losses.separation import separation_loss, silhouette_loss, sky_depth_loss
from r3gw.training.losses.ssim import mean_ssim
from r3gw.training.objective import acting_weights
from r3gw.training.schedule import Schedule

EVERYWHERE = torch.ones(24, 32, dtype=torch.bool)


@pytest.fixture
def pictures() -> tuple[torch.Tensor, torch.Tensor]:
    """Two related random pictures, 24x32."""
    generator = torch.Generator().manual_seed(0)
    first = torch.rand(24, 32, 3, generator=generator)
    noise = 0.2 * torch.randn(24, 32, 3, generator=generator)
    return first, (first + noise).clamp(0, 1)


def turned_camera() -> Camera:
    cam_from_world = torch.eye(4, dtype=torch.float64)
    cam_from_world[:3, :3] = rotation_about_axis(1, 0.6) @ rotation_about_axis(0, -0.3)
    cam_from_world[:3, 3] = torch.tensor([0.3, -0.2, 1.0])
    return Camera(cam_from_world, (61.0, 58.0, 30.5, 19.0), 64, 48)


def test_l1_by_hand():
    rendered, target = torch.zeros(1, 2, 3), torch.tensor([[[0.3, 0.6, 0.9], [1.0, 1.0, 1.0]]])
    left = torch.tensor([[True, False]])
    assert float(masked_l1(rendered, target, left)) == pytest.approx(0.6, abs=1e-6)
    assert float(masked_l1(rendered, target, ~left & left)) == 0.0


def test_ssim_of_equal_pictures_is_one(pictures):
    assert float(mean_ssim(pictures[0], pictures[0], EVERYWHERE)) == pytest.approx(1.0, abs=1e-5)


def test_masked_pixels_do_not_leak(pictures):
    a, b = pictures
    is_valid = EVERYWHERE.clone()
    is_valid[5:12, 8:20] = False
    spoiled = torch.where(is_valid[..., None], a, 1 - a)
    for loss in (masked_l1, mean_ssim):
        before, after = loss(a, b, is_valid), loss(spoiled, b, is_valid)
        assert float(after) == pytest.approx(float(before), abs=1e-7)


def test_reconstruction_is_weighted_as_in_the_paper():
    settings = train_settings()
    schedule = Schedule.of(settings)
    weights = acting_weights(settings, schedule, schedule.warm_up + 1)
    assert weights.l1 == pytest.approx(0.8, rel=1e-12, abs=0)
    assert weights.dissimilarity == pytest.approx(0.2, rel=1e-12, abs=0)
    warming_up = acting_weights(settings, schedule, schedule.warm_up)
    assert (warming_up.l1, warming_up.dissimilarity) == (0, 0)


@pytest.mark.parametrize("domain", ["hemisphere", "sphere"])
def test_directions_are_those_of_the_drawn_angles(domain):
    height, turn = torch.rand(2, 500, generator=torch.Generator().manual_seed(4)).double()
    height = 2 * height - 1 if domain == "sphere" else height
    expected = direction_from_angles(torch.acos(height), 2 * pi * turn)
    found = random_directions(500, domain, torch.Generator().manual_seed(4))
    torch.testing.assert_close(found.double(), expected, rtol=0, atol=1e-6)


def test_directions_cover_the_upper_hemisphere_uniformly():
    generator = torch.Generator().manual_seed(0)
    up = -random_directions(20000, "hemisphere", generator)[:, 1]
    assert float(up.min()) >= 0
    assert float(up.mean()) == pytest.approx(0.5, abs=0.01)  # heights are uniform in [0, 1]
    around = random_directions(20000, "sphere", generator).mean(0)
    torch.testing.assert_close(around, torch.zeros(3), rtol=0, atol=0.02)


def test_positivity_of_a_linear_light():
    """L = x on the unit sphere: mean of min(0, x)^2 over three channels is 3/6."""
    light = torch.zeros(4, 3)
    light[3] = 1 / 0.48860251
    directions = random_directions(200_000, "sphere", torch.Generator().manual_seed(0))
    assert float(positivity_loss(light, directions)) == pytest.approx(0.5, abs=5e-3)


def test_positive_light_costs_nothing():
    light = torch.zeros(25, 3)
    light[0] = sqrt(4 * pi)
    directions = random_directions(100, "sphere", torch.Generator().manual_seed(0))
    assert float(positivity_loss(light, directions)) == 0.0
    assert sh.num_coefficients(4) == 25


@pytest.mark.parametrize(
    ("is_clipped", "expected"), [(False, 3 * (0.3**2 + 0.2**2) / 2), (True, 3 * 0.3**2 / 2)]
)
def test_a_sky_is_compared_with_what_the_photo_shows_of_it(is_clipped, expected):
    """An even sky of 0.5, seen as 0.8 and as 0.3; of clipped pixels only the brighter counts."""
    sky = torch.zeros(4, 3)
    sky[0] = 0.5 * sqrt(4 * pi)
    directions = random_directions(2, "hemisphere", torch.Generator().manual_seed(0))
    radiance = torch.tensor([[0.8], [0.3]]).expand(2, 3)
    clipped = torch.full((2, 3), is_clipped)
    found = visible_sky_loss(sky, sh.basis(directions, 1), radiance, clipped)
    assert float(found) == pytest.approx(expected, rel=1e-5)


def test_normals_from_the_depth_of_a_plane():
    """A slanted plane n.x = d seen by a turned camera with an off-centre principal point."""
    camera = turned_camera()
    rotation = camera.cam_from_world[:3, :3].float()
    normal_cam = torch.nn.functional.normalize(torch.tensor([0.3, -0.5, -0.8]), dim=0)
    depth = -4.0 / (pixel_rays(camera) @ normal_cam)
    found = normals_from_depth(depth, camera)
    expected = (rotation.T @ normal_cam).expand_as(found)
    torch.testing.assert_close(found, expected, rtol=0, atol=2e-3)


def test_normals_from_the_depth_of_a_sphere():
    camera = turned_camera()
    rays = pixel_rays(camera).double()
    centre, radius = torch.tensor([0.1, 0.2, 5.0], dtype=torch.float64), 4.0
    # Nearest root of |t ray - c|^2 = r^2; t is the camera z since rays have z = 1.
    a, b = (rays**2).sum(-1), rays @ centre
    root = b * b - a * (centre @ centre - radius**2)
    hit = root > 0.5
    depth = (b - root.clamp_min(0).sqrt()) / a
    normal_cam = (rays * depth[..., None] - centre) / radius
    expected = normal_cam @ camera.cam_from_world[:3, :3]
    found = normals_from_depth(depth.float(), camera).double()
    inner = hit.clone()
    inner[0], inner[-1], inner[:, 0], inner[:, -1] = False, False, False, False
    cosine = (found * expected).sum(-1)[inner]
    assert int(inner.sum()) > 500
    assert float(torch.rad2deg(torch.acos(cosine.clamp(-1, 1))).max()) < 2.0


def test_normal_loss_by_hand():
    up = torch.tensor([0.0, -1.0, 0.0]).expand(24, 32, 3)
    right = torch.tensor([1.0, 0.0, 0.0]).expand(24, 32, 3)
    assert float(normal_loss(up, up, EVERYWHERE)) == pytest.approx(0.0, abs=1e-6)
    assert float(normal_loss(up, right, EVERYWHERE)) == pytest.approx(1.0, abs=1e-6)
    assert float(normal_loss(up, right, ~EVERYWHERE)) == 0.0


def test_flatness_is_the_mean_smallest_visible_scale():
    smallest = torch.tensor([1.0, 4.0, 9.0])
    visible = torch.tensor([True, True, False])
    assert float(flatness_loss(smallest, visible)) == pytest.approx(2.5, rel=1e-6)
    assert float(flatness_loss(smallest, ~(visible | ~visible))) == 0.0


def test_separation_on_hand_made_layers():
    """Each set is punished only on the other's valid pixels."""
    foreground = torch.tensor([[0.3, 0.6], [0.9, 1.2]])
    sky = torch.tensor([[1.5, 1.8], [2.1, 2.4]])
    is_sky = torch.tensor([[True, False], [True, False]])
    is_valid = torch.tensor([[True, True], [True, False]])
    expected = (0.3 + 1.8 + 0.9) / 9
    found = separation_loss(foreground, sky, is_sky, is_valid)
    assert float(found) == pytest.approx(expected, rel=1e-6)


def test_silhouette_on_a_hand_made_layer():
    """Opacity on sky, a tenth of the transparency elsewhere, nothing on occluders."""
    opacity = torch.tensor([[0.3, 0.6], [0.9, 0.2]])
    is_sky = torch.tensor([[True, False], [True, False]])
    is_valid = torch.tensor([[True, True], [True, False]])
    expected = (0.3 + 0.1 * 0.4 + 0.9) / 3
    found = silhouette_loss(opacity, is_sky, is_valid, 0.1)
    assert float(found) == pytest.approx(expected, rel=1e-6)


def test_sky_depth_value_and_gradient():
    depths = torch.tensor([1.0, 3.0, 50.0, 60.0, 1000.0], requires_grad=True)
    visible = torch.tensor([True, True, True, True, False])
    loss = sky_depth_loss(depths, visible, 2, gamma=0.02)
    assert float(loss.detach()) == pytest.approx(exp(-0.02 * (55 - 2)), rel=1e-5)
    loss.backward()
    assert depths.grad is not None
    torch.testing.assert_close(depths.grad[[0, 1, 4]], torch.zeros(3), rtol=0, atol=0)
    slope = -0.02 * float(loss.detach()) / 2  # descent pushes the sky away
    torch.testing.assert_close(depths.grad[2:4], torch.full((2,), slope), rtol=1e-5, atol=0)


@pytest.mark.parametrize("hidden", [slice(0, 2), slice(2, 5)])
def test_sky_depth_is_zero_without_one_of_the_sets(hidden):
    visible = torch.ones(5, dtype=torch.bool)
    visible[hidden] = False
    depths = torch.arange(5.0, requires_grad=True)
    assert float(sky_depth_loss(depths, visible, 2, gamma=0.02).detach()) == 0.0


def test_given_normals_by_hand():
    """Half a turn costs 2, a right angle 1, and pixels without a normal nothing."""
    given = torch.zeros(1, 4, 3, dtype=torch.int8)
    given[0, :3] = torch.tensor([0, 0, -127], dtype=torch.int8)
    rendered = torch.tensor([[[0.0, 0, -1], [0, 0, 1], [1, 0, 0], [0, 0, 1]]])
    everywhere = torch.ones(1, 4, dtype=torch.bool)
    loss = given_normal_loss(rendered, given, everywhere)
    torch.testing.assert_close(loss, torch.tensor(1.0), rtol=0, atol=1e-6)
    first = torch.tensor([[True, False, False, True]])
    torch.testing.assert_close(
        given_normal_loss(rendered, given, first), torch.tensor(0.0), rtol=0, atol=1e-6
    )
    assert float(given_normal_loss(rendered, given, ~everywhere)) == 0.0
