"""Sunlit surfaces against closed forms and integrals; gradients against finite differences."""

from math import cos, pi, radians, sin

import pytest
import torch

from r3gw.lighting.sun import PointSun
from r3gw.rendering import reference, splats
from r3gw.rendering.brdf_table import lookup
from r3gw.rendering.channels import COLOUR, NORMAL
from r3gw.rendering.compose import Sunlight, draw, shaded_splats
from r3gw.rendering.cook_torrance import DIELECTRIC_F0
from r3gw.rendering.sun_shadow import SunShadow, reach_in
from r3gw.rendering.sunlight import bounced_irradiance, direct_irradiance, ggx, sun_radiance

SUN = PointSun(
    torch.nn.functional.normalize(torch.tensor([0.3, -0.6, -0.7]), dim=0),
    torch.tensor([2.0, 1.6, 1.1]),
)


@pytest.mark.parametrize("view_deg", [0.0, 40.0, 75.0])
@pytest.mark.parametrize("roughness", [0.3, 0.6, 1.0])
def test_the_lobe_integrates_to_the_split_sums_table(view_deg, roughness):
    """Quadrature over the hemisphere; the table comes from samples of visible normals."""
    view = torch.tensor([sin(radians(view_deg)), 0.0, cos(radians(view_deg))]).double()
    height = (torch.arange(600, dtype=torch.float64) + 0.5) / 600
    turn = (torch.arange(720, dtype=torch.float64) + 0.5) / 720 * 2 * pi
    rise, around = torch.meshgrid(height, turn, indexing="ij")
    level = torch.sqrt(1 - rise**2)
    lights = torch.stack([level * around.cos(), level * around.sin(), rise], dim=-1).reshape(-1, 3)
    normal = torch.tensor([0.0, 0.0, 1.0]).double()
    # The lobe does not change if the two directions change places: many views, one light.
    count = len(lights)
    found = ggx(normal.expand(count, 3), lights, torch.full((count,), roughness).double(), view)
    integral = float((found * lights[:, 2]).mean() * 2 * pi)
    f1, f2 = lookup(view[2:].float(), torch.tensor([roughness]))
    expected = float(DIELECTRIC_F0 * f1 + f2)
    assert integral == pytest.approx(expected, rel=0.03, abs=2e-4)


def test_matt_surfaces_follow_lamberts_law():
    angles = torch.tensor([0.0, 30.0, 60.0, 120.0]).deg2rad()
    along = torch.nn.functional.normalize(torch.tensor([0.7, 0.0, 0.3]), dim=0)
    across = torch.linalg.cross(SUN.direction, along)
    across = across / across.norm()
    normals = angles.cos()[:, None] * SUN.direction + angles.sin()[:, None] * across
    albedo = torch.tensor([[0.2, 0.5, 0.8]]).expand(4, 3)
    rough = torch.full((4,), 0.5)
    found = sun_radiance(normals, normals, albedo, rough, SUN, with_specular=False)
    lit = angles.cos().clamp_min(0)[:, None]
    torch.testing.assert_close(found, albedo / pi * SUN.irradiance * lit, rtol=1e-5, atol=1e-6)
    assert not found[3].any()
    assert not sun_radiance(normals, normals, albedo, rough, SUN, with_specular=True)[3].any()


def test_what_others_send_back():
    """A surface that sees nothing but others in the upper half loses all of the sky's share."""
    lost = -pi / (4 * pi) ** 0.5
    occlusion = torch.tensor([[0.0, 1.0], [lost, 0.0], [0.5 * lost, 0.0]])
    found = bounced_irradiance(occlusion, SUN, 0.1)
    expected = torch.tensor([[0.0], [0.1], [0.05]]) * SUN.irradiance
    torch.testing.assert_close(found, expected, rtol=1e-5, atol=1e-7)


LIGHT = 0.3 * torch.rand(25, 3, generator=torch.Generator().manual_seed(3))


def sunlit_sum(splats_of, model, camera, sun):
    """A random weighting of the colours of a model's foreground in the sun."""
    light = LIGHT.to(model.foreground["means"])
    normals = splats_of(model, camera, light, None).features[: len(model.foreground), NORMAL]
    direct = direct_irradiance(model, normals, camera, sun)
    colours = splats_of(model, camera, light, None, beside=direct).colours
    colours = colours[: len(model.foreground)]
    weights = torch.rand(colours.shape, generator=torch.Generator().manual_seed(4))
    return (weights.to(colours) * colours).sum()


LEARNED = ("albedo_logits", "roughness_logits", "quaternions")


def test_gradients_are_those_of_finite_differences(model, camera):
    """Of material, orientation and the sun, in float64."""
    model.foreground.double()
    model.sky.double()
    direction = SUN.direction.double().requires_grad_()
    irradiance = SUN.irradiance.double().requires_grad_()
    sun = PointSun(direction, irradiance)
    sunlit_sum(reference.splats_of, model, camera, sun).backward()
    tensors = [model.foreground[name] for name in LEARNED] + [direction, irradiance]
    generator = torch.Generator().manual_seed(5)
    for tensor in tensors:
        assert tensor.grad is not None
        flat = tensor.detach().view(-1)
        places = torch.randint(flat.numel(), (6,), generator=generator).tolist()
        for place in places:
            kept, step, values = float(flat[place]), 1e-6, []
            for side in (1, -1):
                flat[place] = kept + side * step
                with torch.no_grad():
                    values.append(float(sunlit_sum(reference.splats_of, model, camera, sun)))
            flat[place] = kept
            expected = (values[0] - values[1]) / (2 * step)
            assert float(tensor.grad.view(-1)[place]) == pytest.approx(expected, rel=1e-5, abs=1e-7)


def test_the_kernel_shades_as_the_plain_form(model, camera):
    """Values and gradients: the albedo's by the highlight cancels in both."""
    gradients = []
    for splats_of, kind in ((splats.splats_of, "float"), (reference.splats_of, "double")):
        getattr(model.foreground, kind)()
        getattr(model.sky, kind)()
        for parameter in model.foreground.parameters():
            parameter.grad = None
        sun = PointSun(*(getattr(each, kind)() for each in (SUN.direction, SUN.irradiance)))
        total = sunlit_sum(splats_of, model, camera, sun)
        total.backward()
        found = [model.foreground[name].grad.double() for name in LEARNED]
        gradients.append([total.detach().double(), *found])
    for ours, exact in zip(*gradients, strict=True):
        size = max(float(exact.abs().max()), 1.0)
        torch.testing.assert_close(ours, exact, rtol=2e-3, atol=3e-5 * size)


class _Left(SunShadow):
    """The sun reaches what lies left of the picture's middle alone."""

    def seen_from(self, camera, depth, is_covered):  # noqa: ARG002
        lit = torch.zeros_like(depth)
        lit[:, : camera.width // 2] = 1.0
        return lit


@torch.no_grad()
def test_gaussians_are_in_the_sun_or_in_the_shade(model, camera):
    """Those whose pixels all lie on one side have the colours of that side, others a mixture."""
    model.foreground["log_scales"].sub_(2.5)  # a few pixels wide
    shadow = _Left(camera, torch.zeros(1, 1), torch.zeros(1, 1), 0.0, 0.0, 1.0)
    light = LIGHT + SUN.sh(4)
    half, bright = (
        shaded_splats(model, camera, light, None, sunlight=Sunlight(SUN, each))
        for each in (reach_in(model, camera, shadow), None)
    )
    dark = splats.splats_of(model, camera, light - SUN.sh(4), None)
    drawn = draw(bright, camera)
    x, radius = drawn.means2d[:, 0], drawn.radii_px
    is_seen, middle = radius > 0, camera.width // 2
    is_left = is_seen & (x + radius < middle) & (x - radius > 0)
    is_right = is_seen & (x - radius > middle) & (x + radius < camera.width)
    count = len(model.foreground)
    assert int(is_left[:count].sum()) > 2
    assert int(is_right[:count].sum()) > 2
    close = {"rtol": 0, "atol": 1e-4}
    torch.testing.assert_close(half.colours[is_left], bright.colours[is_left], **close)
    torch.testing.assert_close(half.colours[is_right], dark.colours[is_right], **close)
    low, high = dark.colours[:count] - 1e-5, bright.colours[:count] + 1e-5
    assert bool(((half.colours[:count] >= low) & (half.colours[:count] <= high)).all())
    assert float((bright.colours - dark.colours).abs().max()) > 0.05


def test_nothing_changes_where_there_is_no_sun(model, camera):
    found = shaded_splats(model, camera, LIGHT, None).features[:, COLOUR]
    expected = splats.splats_of(model, camera, LIGHT, None).features[:, COLOUR]
    torch.testing.assert_close(found, expected, rtol=0, atol=0)
