"""Occlusion against closed forms: open sky, a wall, a roof, a Monte Carlo integral."""

from math import pi

import pytest
import torch
from numpy.testing import assert_allclose

from r3gw.lighting import sh
from r3gw.lighting.irradiance import irradiance
from r3gw.model.model_file import load_model, save_model
from r3gw.model.occlusion import (
    OpacityGrid,
    blocked_irradiance,
    opacity_grid,
    outer_normals,
    smoothed,
    update_occlusion,
    upper_directions,
    visibility,
)
from r3gw.model.rows import OCCLUSION, Rows
from r3gw.model.settings import OcclusionSettings
from r3gw.rendering import reference
from r3gw.rendering.splats import splats_of

UP = torch.tensor([0.0, -1.0, 0.0])


@pytest.fixture
def shadows():
    """Shadows without any light from blocked directions, nothing smoothed."""
    return OcclusionSettings(
        enabled=True,
        first=0,
        interval=1,
        voxels=64,
        directions=512,
        reach=90,
        offset=1.5,
        bounce=0.0,
        neighbours=1,
    )


def sheet(centre, across, along, spacing, opacity=0.98):
    """Flat Gaussians that tile the rectangle spanned by two axes."""
    u, v = torch.tensor(across), torch.tensor(along)
    counts = [round(float(2 * axis.norm()) / spacing) + 1 for axis in (u, v)]
    a, b = torch.meshgrid(*(torch.linspace(-1, 1, n) for n in counts), indexing="ij")
    means = torch.tensor(centre) + a.reshape(-1, 1) * u + b.reshape(-1, 1) * v
    normal = torch.linalg.cross(u, v)
    scales = torch.full((len(means), 3), 0.6 * spacing)
    scales[:, int(normal.abs().argmax())] = 1e-3
    return means, scales.log(), torch.full((len(means),), opacity).logit()


def rows_of(*sheets):
    """Foreground rows of sheets that are aligned with the axes."""
    means, log_scales, opacities = (torch.cat(parts) for parts in zip(*sheets, strict=True))
    values = {
        "means": means,
        "log_scales": log_scales,
        "quaternions": torch.tensor([1.0, 0.0, 0.0, 0.0]).repeat(len(means), 1),
        "opacity_logits": opacities,
    }
    rows = Rows("foreground.", values)
    rows.add_computed(OCCLUSION, torch.zeros(len(means), 25))
    return rows


def received(occlusion, normals, light):
    """Irradiance without and with occlusion."""
    without = irradiance(light, normals)
    return without, without + occlusion @ light


def uniform():
    """Radiance 1 from everywhere."""
    light = torch.zeros(25, 3)
    light[0] = (4 * pi) ** 0.5
    return light


def test_open_ground_loses_nothing(shadows):
    """A level sheet sees the whole sky."""
    rows = rows_of(sheet((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 0.0, 2.0), 0.1))
    update_occlusion(rows, [torch.tensor([0.0, -3.0, 0.0])], shadows)
    assert_allclose(rows[OCCLUSION].numpy(), 0.0, rtol=0, atol=1e-3)


def test_ground_before_an_endless_wall_gets_half(shadows):
    """At the foot of a high wall half of the sky is blocked, and so is half of the irradiance."""
    ground = sheet((0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (0.0, 0.0, 1.5), 0.1)
    wall = sheet((0.0, -2.0, 1.5), (3.0, 0.0, 0.0), (0.0, 2.0, 0.0), 0.1)
    rows = rows_of(ground, wall)
    update_occlusion(rows, [torch.tensor([0.0, -1.5, -6.0])], shadows)
    at = (rows["means"] - torch.tensor([0.0, 0.0, 1.1])).norm(dim=1).argmin()
    without, with_wall = received(rows[OCCLUSION][at : at + 1], UP[None], uniform())
    assert_allclose(without.detach().numpy(), pi, rtol=1e-5, atol=0)
    # Beside a wall of height h and half width w at distance d = 0.4: the wall's form factor.
    blocked = _wall_form_factor(distance=0.4, height=4.0, half_width=3.0)
    assert_allclose((with_wall / pi).detach().numpy(), 1 - blocked, rtol=0, atol=0.05)


def _wall_form_factor(distance, height, half_width):
    """Share of a level patch's irradiance that an upright rectangle blocks (Howell, B-4)."""
    x, y = height / distance, half_width / distance
    far = (1 + x * x) ** 0.5
    corner = (torch.atan(torch.tensor(y)) - torch.atan(torch.tensor(y / far)) / far) / (2 * pi)
    return 2 * float(corner)


def test_closed_roof_leaves_the_light_from_below(shadows):
    """A ceiling right above blocks the sky, but not what the lower half of the light sends."""
    roof = sheet((0.0, -0.8, 0.0), (3.0, 0.0, 0.0), (0.0, 0.0, 3.0), 0.1)
    ground = sheet((0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (0.0, 0.0, 3.0), 0.1)
    rows = rows_of(ground, roof)
    update_occlusion(rows, [torch.tensor([0.0, -0.4, -9.0])], shadows)
    at = rows["means"].norm(dim=1).argmin()
    light = uniform()
    under_roof = received(rows[OCCLUSION][at : at + 1], UP[None], light)[1]
    assert float(under_roof.max()) < 0.12 * pi
    wall_normal = torch.tensor([[0.0, 0.0, -1.0]])
    lost = torch.ones(1, shadows.directions)
    facing = blocked_irradiance(lost, wall_normal, upper_directions(shadows.directions), 4)
    left = received(facing, wall_normal, light)[1]
    assert_allclose(left.numpy(), pi / 2, rtol=0.01, atol=0)


def test_blocked_irradiance_is_the_integral():
    """Against a Monte Carlo integral over the sphere, for a random light and random blocking."""
    generator = torch.Generator().manual_seed(3)
    light = torch.randn(25, 3, generator=generator)
    normal = torch.nn.functional.normalize(torch.tensor([[0.3, -0.5, -0.6]]), dim=-1)
    directions = upper_directions(4096)
    lost = (directions[:, 0] > 0.2).float()[None]
    ours = blocked_irradiance(lost, normal, directions, 4) @ light
    drawn = torch.nn.functional.normalize(torch.randn(400_000, 3, generator=generator), dim=-1)
    is_lost = (drawn[:, 0] > 0.2) & (drawn[:, 1] < 0)
    cosine = (drawn @ normal[0]).clamp_min(0) * is_lost
    expected = -(sh.radiance(light, drawn) * cosine[:, None]).mean(0, keepdim=True) * 4 * pi
    assert_allclose(ours.numpy(), expected.numpy(), rtol=0, atol=0.03)


def test_visibility_is_the_transmittance_of_the_voxels_passed():
    """Straight up from the floor of a grid, every voxel counts once; outside all is open.

    So is what lies behind a surface: nothing that comes from there could light it.
    """
    depth = torch.zeros(5, 12, 5)
    depth[2, 3, 2], depth[2, 6, 2], depth[2, 9, 2] = 0.4, 0.5, 0.7  # the last: a start's own
    grid = OpacityGrid(torch.zeros(3), 1.0, depth)
    places = [[2.5, 9.5, 2.5], [2.5, 4.5, 2.5], [1.5, 9.5, 2.5], [2.5, 40.0, 2.5], [2.5, 9.5, 2.5]]
    starts, normals = torch.tensor(places), UP * torch.tensor([[1.0], [1.0], [1.0], [1.0], [-1.0]])
    seen = visibility(grid, starts, UP[None], 10, normals)[:, 0]
    expected = torch.tensor([-0.9, -0.4, 0.0, 0.0, 0.0]).exp()
    assert_allclose(seen.numpy(), expected.numpy(), rtol=1e-6, atol=0)


def test_the_grid_holds_the_opacity_of_a_wall():
    """Summed through a sheet of overlapping Gaussians: its optical depth, whatever the voxels."""
    rows = rows_of(sheet((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), 0.1, opacity=0.3))
    grid = opacity_grid(rows, 32)
    middle = tuple(n // 4 for n in grid.depth.shape[:2])
    inner = grid.depth[middle[0] : -middle[0], middle[1] : -middle[1]].sum(-1)
    face = 2 * pi * 0.06**2
    expected = -torch.log1p(torch.tensor(-0.3)) * face / 0.1**2
    assert_allclose(float(inner.mean()), float(expected), rtol=0.05, atol=0)


def test_normals_point_to_where_the_cameras_are(shadows):
    """The wall's axis is turned out of the wall, from either sign."""
    rows = rows_of(sheet((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), 0.1))
    means = rows["means"].detach()
    grid = opacity_grid(rows, shadows.voxels)
    axes = torch.tensor([0.0, 0.0, 1.0]).repeat(len(means), 1)
    axes[::2] *= -1
    turned = outer_normals(grid, means, axes, [torch.tensor([0.5, -0.5, -4.0])], 1.5, 60)
    assert_allclose(turned.numpy(), torch.tensor([[0.0, 0.0, -1.0]]).expand_as(turned).numpy())


def test_smoothing_averages_like_normals_only():
    """Two faces of a corner keep their own values; unequal opacities weigh."""
    means = torch.tensor([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]])
    normals = torch.tensor([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    values = torch.tensor([[1.0], [4.0], [100.0]])
    result = smoothed(values, means, normals, torch.tensor([0.8, 0.4, 0.5]), 3)
    assert_allclose(result.numpy(), [[2.0], [2.0], [100.0]], rtol=2e-4, atol=0)


@pytest.mark.parametrize("degree", [2, 4])
def test_shading_subtracts_what_is_lost(model, camera, degree):
    """The kernel equals the plain form, forwards and backwards, and is dimmer by what is lost."""
    generator = torch.Generator().manual_seed(1)
    light = (0.2 * uniform())[: (degree + 1) ** 2]
    light = (light + 0.02 * torch.randn(light.shape, generator=generator)).requires_grad_()
    before = splats_of(model, camera, light, None).features[:, :3].detach()
    count = len(model.foreground)
    lost = -0.6 * torch.rand(count, 25, generator=generator)
    model.foreground.add_computed(OCCLUSION, lost * (torch.arange(25) == 0))
    pull = torch.randn(before.shape, generator=generator)
    inputs = [light, model.foreground["albedo_logits"], model.foreground["quaternions"]]
    found = []
    for form in (splats_of, reference.splats_of):
        colours = form(model, camera, light, None).features[:, :3]
        found.append((colours.detach(), torch.autograd.grad((colours * pull).sum(), inputs)))
    (ours, gradients), (plain, expected) = found
    torch.testing.assert_close(ours, plain, rtol=1e-5, atol=1e-6)
    for one, other in zip(gradients, expected, strict=True):
        torch.testing.assert_close(one, other, rtol=2e-3, atol=2e-5)
    albedo = model.foreground["albedo_logits"].detach().sigmoid()
    change = albedo / pi * (model.foreground[OCCLUSION][:, : len(light)] @ light.detach())
    expected_linear = before[:count] ** 2.2 + change
    is_inside = (expected_linear > 1e-3) & (before[:count] < 1)
    dimmed = ours[:count] ** 2.2
    torch.testing.assert_close(dimmed[is_inside], expected_linear[is_inside], rtol=1e-4, atol=1e-5)
    assert bool((dimmed < before[:count] ** 2.2)[is_inside].all())


def test_model_file_keeps_occlusion(model, tmp_path):
    lost = torch.randn(len(model.foreground), 25, generator=torch.Generator().manual_seed(0))
    model.foreground.add_computed(OCCLUSION, lost)
    save_model(model, tmp_path / "model.safetensors")
    again = load_model(tmp_path / "model.safetensors").foreground
    assert not again[OCCLUSION].requires_grad
    assert_allclose(again[OCCLUSION].numpy(), lost.numpy())
