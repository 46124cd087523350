"""The sky hemisphere: uniform sampling, round trips, ranges, initial dome."""

from math import pi

import numpy as np
import pytest
import torch
from scipy.stats import chisquare

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.model.initial import initial_points, load_initial, save_initial, seen_azimuths
from r3gw.model.settings import InitSettings, SkySettings
from r3gw.model.sky import Sky, SkyDome, even_dome, initial_sky, sample_dome

DOME = SkyDome(torch.tensor([1.0, 2.0, 3.0]), 5.0, (-0.5, 2.0))
SKY = SkySettings(
    count_per_radius=100,
    min_count=10,
    max_count=100000,
    azimuth_range="cameras",
    around="scene",
    least_opacity=0.0,
    is_closed=False,
)

INIT = InitSettings(opacity=0.1, roughness=0.5, albedo=0.7, light_radiance=1.0)


def make_sky(count: int = 2000) -> Sky:
    angles = sample_dome(DOME, count, torch.Generator().manual_seed(0))
    return initial_sky(DOME, angles, INIT)


def test_dome_samples_are_uniform_per_area():
    """Cells of equal height and azimuth have equal area on a sphere (Archimedes)."""
    angles = sample_dome(DOME, 40_000, torch.Generator().manual_seed(1)).numpy()
    height = np.cos(angles[:, 0])
    turn = (angles[:, 1] + 0.5) / 2.5
    counts, _, _ = np.histogram2d(height, turn, bins=8, range=[[0, 1], [0, 1]])
    assert counts.sum() == 40_000
    assert chisquare(counts.ravel()).pvalue > 1e-3


@pytest.mark.parametrize("azimuth_rad", [(-0.5, 2.0), (-pi, pi)])
def test_an_even_dome_is_more_even_than_chance(azimuth_rad):
    """Cells of equal area hold the same number, but for a few at their borders."""
    dome = SkyDome(DOME.centre, DOME.radius, azimuth_rad)
    first, last = azimuth_rad
    angles = even_dome(dome, 4000).double().numpy()
    cells = (np.cos(angles[:, 0]), (angles[:, 1] - first) / (last - first))
    edges = [[-1e-6, 1 + 1e-6]] * 2  # angles are float32
    counts, _, _ = np.histogram2d(*cells, bins=(8, 8), range=edges)
    assert counts.sum() == 4000
    np.testing.assert_allclose(counts, 62.5, rtol=0, atol=5)  # by chance the spread alone is 7.9


def test_a_closed_sky_starts_evenly():
    cameras = [looking(0.0)]
    closed = SKY.model_copy(update={"is_closed": True, "least_opacity": 0.95})
    initial = initial_points(torch.randn(50, 3), cameras, closed, seed=0)
    expected = even_dome(initial.dome, len(initial.sky_angles))
    torch.testing.assert_close(initial.sky_angles, expected, rtol=0, atol=0)


def test_positions_lie_on_the_upper_hemisphere():
    sky = make_sky()
    offsets = sky.means().detach() - DOME.centre
    torch.testing.assert_close(offsets.norm(dim=-1), torch.full((2000,), 5.0), rtol=1e-5, atol=0)
    assert float(offsets[:, 1].max()) <= 1e-4  # up is -y


def test_angles_of_inverts_positions():
    sky = make_sky()
    again = sky.angles_of(sky.means().detach())
    torch.testing.assert_close(again, sky.rows["angles"].detach(), rtol=0, atol=2e-3)


def test_points_outside_are_put_back_in_range():
    sky = make_sky(3)
    below = torch.tensor([[1.0, 9.0, 8.0], [1.0, 2.0, -9.0]])  # under the ground, behind
    theta, phi = sky.angles_of(below).unbind(-1)
    assert float(theta.max()) <= pi / 2 + 1e-6
    assert float(phi.min()) >= -0.5
    assert float(phi.max()) <= 2.0


def test_clamping_keeps_ranges_after_a_step():
    sky = make_sky(5)
    with torch.no_grad():
        sky.rows["angles"].add_(10.0)
        sky.radius.sub_(100.0)
    sky.clamp_to_dome()
    angles = sky.rows["angles"].detach()
    assert float(angles[:, 0].max()) <= pi / 2 + 1e-6
    assert float(angles[:, 1].max()) <= 2.0
    assert float(sky.radius.detach()) > 0


def test_dome_fits_the_points():
    """Robust box midpoint, 99th percentile radius, count per radius."""
    generator = torch.Generator().manual_seed(0)
    points = torch.rand(5000, 3, generator=generator) * 4 + torch.tensor([10.0, -2.0, 0.0])
    points[:5] += 1000.0  # strays
    initial = initial_points(points, [looking(0.0)], SKY, seed=0)
    torch.testing.assert_close(
        initial.dome.centre, torch.tensor([12.0, 0.0, 2.0]), rtol=0, atol=0.1
    )
    expected = np.quantile(np.linalg.norm(points - points.mean(0), axis=1), 0.99)
    np.testing.assert_allclose(initial.dome.radius, expected, rtol=1e-5, atol=0)
    assert len(initial.sky_angles) == round(100 * initial.dome.radius)


def test_a_dome_around_cameras_holds_them_all():
    """A camera outside would look through the sky at what stands in it."""
    points = torch.rand(500, 3, generator=torch.Generator().manual_seed(0))
    away = looking(0.0).cam_from_world.clone()
    away[2, 3] = 20.0  # the camera stands 20 units before the scene
    cameras = [looking(0.0), Camera(away, (50.0, 50.0, 50.0, 50.0), 100, 100)]
    around = SKY.model_copy(update={"around": "cameras"})
    dome = initial_points(points, cameras, around, seed=0).dome
    distance = float((cameras[1].centre.float() - dome.centre).norm())
    np.testing.assert_allclose(dome.radius, 2 * distance, rtol=1e-5, atol=0)
    alone = initial_points(points, cameras, SKY, seed=0).dome
    assert alone.radius < 1.0 < distance
    wide = (points - 0.5) * 200  # holds the cameras well within
    radii = [initial_points(wide, cameras, sky, seed=0).dome.radius for sky in (SKY, around)]
    assert radii[0] == radii[1] > 100.0


def test_an_opaque_sky_stays_opaque():
    sky = make_sky(5)
    with torch.no_grad():
        sky.rows["opacity_logits"].copy_(torch.tensor([-9.0, -1.0, 0.0, 2.0, 9.0]))
    before = sky.rows["opacity_logits"].detach().clone()
    sky.keep_opaque(0.0)
    assert torch.equal(sky.rows["opacity_logits"].detach(), before)
    sky.keep_opaque(0.75)
    got = torch.sigmoid(sky.rows["opacity_logits"].detach())
    expected = torch.sigmoid(before).clamp_min(0.75)
    torch.testing.assert_close(got, expected, rtol=1e-5, atol=0)


def looking(yaw: float) -> Camera:
    """A 90-degree camera that looks along azimuth ``yaw``."""
    cam_from_world = torch.eye(4, dtype=torch.float64)
    cam_from_world[:3, :3] = rotation_about_axis(1, -yaw)
    return Camera(cam_from_world, (50.0, 50.0, 50.0, 50.0), 100, 100)


def test_azimuth_range_is_what_cameras_see():
    first, last = seen_azimuths([looking(0.3)])
    # A wide camera sees 45 degrees to each side at the horizon; corners reach no further.
    assert 0.3 - pi / 4 - 0.2 < first < 0.3 - pi / 4 + 0.01
    assert 0.3 + pi / 4 - 0.01 < last < 0.3 + pi / 4 + 0.2


def test_azimuth_range_across_the_seam():
    first, last = seen_azimuths([looking(pi - 0.1), looking(-pi + 0.1)])
    assert 1.0 < last - first < 2.5
    middle = 0.5 * (first + last)
    assert abs(np.cos(middle) + 1) < 0.01


def test_cameras_all_round_see_the_whole_circle():
    assert seen_azimuths([looking(k * pi / 3) for k in range(6)]) == (-pi, pi)


def test_initial_file_round_trip(tmp_path):
    points = torch.rand(50, 3, generator=torch.Generator().manual_seed(0))
    initial = initial_points(points, [looking(0.0)], SKY, seed=0)
    save_initial(initial, tmp_path / "initial.npz")
    again = load_initial(tmp_path / "initial.npz")
    torch.testing.assert_close(again.sky_angles, initial.sky_angles, rtol=0, atol=0)
    assert again.dome.azimuth_rad == initial.dome.azimuth_rad


def test_no_points_is_a_clear_error():
    with pytest.raises(InputError, match="no points"):
        initial_points(torch.zeros(0, 3), [looking(0.0)], SKY, seed=0)


def test_sky_colours_are_display_values_in_the_direction_of_the_look():
    """A light that grows upwards: bright overhead, dark at the horizon, never outside [0, 1]."""
    sky = make_sky()
    light = torch.zeros(4, 3)
    light[1] = -1.0 / 0.48860251  # -y is up: radiance = height of the look
    colours = sky.colours(light, sky.centre).detach()
    height = torch.cos(sky.rows["angles"].detach()[:, 0])
    expected = (height + 0.5).clamp(0, 1)[:, None].expand(-1, 3)
    torch.testing.assert_close(colours, expected, rtol=0, atol=1e-4)
