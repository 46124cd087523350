"""A roof over matt ground in the sun: pictures, baked colours and files show its shadow."""

from math import cos, pi, radians, sin, tan

import numpy as np
import pytest
import torch

from r3gw.geometry.cameras import Camera
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.geometry.similarity import Similarity
from r3gw.lighting import sh
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.lighting.sun import PointSun
from r3gw.relight.bake import bake
from r3gw.relight.files.lights_file import read_lights, write_lights
from r3gw.relight.files.ply import Placement, write_ply
from r3gw.relight.gaussians import Relightable
from r3gw.relight.load import load_relightable
from r3gw.relight.move import moved
from r3gw.relight.picture import frame
from r3gw.relight.tone import CURVES, linear_from_scene, scene_linear

SPACING, ROOF_HEIGHT, ROOF_HALF = 0.08, 1.5, 0.9
ALBEDO, SKY_RADIANCE, IRRADIANCE = 0.5, 0.2, 2.0
CAMERA = Camera.looking_at([0.0, 0.0, 0.0], position=[0.0, -9.0, -4.0], width=60, height=48)


def sheet(height: float, half: float) -> torch.Tensor:
    steps = torch.arange(-half, half + SPACING / 2, SPACING)
    x, z = torch.meshgrid(steps, steps, indexing="ij")
    return torch.stack([x, torch.full_like(x, -height), z], dim=-1).reshape(-1, 3)


def scene(**changes) -> Relightable:
    means = torch.cat([sheet(0.0, 4.0), sheet(ROOF_HEIGHT, ROOF_HALF)])
    count = len(means)
    facts = {
        "means": means,
        "quaternions": torch.tensor([1.0, 0.0, 0.0, 0.0]).repeat(count, 1),
        "log_scales": torch.tensor([0.6 * SPACING, 0.002, 0.6 * SPACING]).log().repeat(count, 1),
        "opacity_logits": torch.full((count,), 4.0),
        "albedo": torch.full((count, 3), ALBEDO),
        "roughness": torch.full((count,), 0.8),
        "lights": {"p": sunlight(40.0, 0.0)},
        "light_degree": 4,
        "with_specular": False,
        "has_point_sun": True,
    }
    return Relightable(**(facts | changes))


def sunlight(elevation_deg: float, azimuth_deg: float) -> Light:
    elevation, azimuth = radians(elevation_deg), radians(azimuth_deg)
    level = cos(elevation)
    towards = torch.tensor([level * sin(azimuth), -sin(elevation), level * cos(azimuth)])
    point = PointSun(towards, torch.full((3,), IRRADIANCE))
    return Light(point.sh(4) + sh.constant(SKY_RADIANCE, 4), LearnedSky(torch.zeros(4, 3)), point)


def linear(gaussians: Relightable, light: Light) -> torch.Tensor:
    return linear_from_scene(frame(gaussians, CAMERA, light, scene_linear))[..., 1]


def value_at(picture: torch.Tensor, point: list[float]) -> float:
    place = torch.tensor(point).double()
    x, y, z = (CAMERA.cam_from_world[:3, :3] @ place + CAMERA.cam_from_world[:3, 3]).tolist()
    fx, fy, cx, cy = CAMERA.intrinsics
    return float(picture[int(fy * y / z + cy), int(fx * x / z + cx)])


@pytest.mark.parametrize("azimuth", [0.0, 90.0, 270.0])
def test_the_shadow_walks_and_is_as_dark_as_the_sky_leaves_it(azimuth):
    elevation = 40.0
    picture = linear(scene(), sunlight(elevation, azimuth))
    shift = ROOF_HEIGHT / tan(radians(elevation))
    away = [-sin(radians(azimuth)), 0.0, -cos(radians(azimuth))]
    shade = value_at(picture, [shift * each for each in away])
    sunny = value_at(picture, [-2.5 * away[0], 0.0, -2.5 * away[2]])
    ambient = ALBEDO * SKY_RADIANCE
    lit = ambient + ALBEDO / pi * IRRADIANCE * sin(radians(elevation))
    assert shade == pytest.approx(ambient, rel=0.08, abs=0)
    assert sunny == pytest.approx(lit, rel=0.05, abs=0)


def test_half_a_sharp_sun_leaves_the_rest_to_sh():
    light = sunlight(40.0, 90.0)
    whole, none = (linear(scene(sharp=share), light) for share in (1.0, 0.0))
    half = linear(scene(sharp=0.5), light)
    unlit = linear(scene(has_point_sun=False), light)
    torch.testing.assert_close(none, unlit, rtol=0, atol=2e-5)
    # Display values are mixed along edges, so linear ones agree away from them alone.
    middle = (half - 0.5 * (whole + none)).abs()
    assert float(middle.median()) < 0.005


def test_baked_colours_look_like_the_picture():
    gaussians, light, curve = scene(), sunlight(40.0, 90.0), CURVES["standard"]
    picture = frame(gaussians, CAMERA, light, curve)
    baked = bake(gaussians, [CAMERA], light, curve)
    again = gaussians.drawn(baked.colours, CAMERA).features
    inner = (slice(10, -10), slice(12, -12))
    error = (again - picture)[inner].square().mean()
    unlit = bake(scene(has_point_sun=False), [CAMERA], light, curve)
    flat = gaussians.drawn(unlit.colours, CAMERA).features
    assert float(error) < 0.15 * float((flat - picture)[inner].square().mean())


@pytest.mark.parametrize("coordinates", ["scene", "source"])
def test_files_keep_the_sun(tmp_path, coordinates):
    gaussians = scene(sharp=0.7, sun_bounce=0.1)
    turn = Similarity(2.0, rotation_about_axis(0, 0.4), torch.tensor([1.0, 2.0, 3.0]).double())
    shown = gaussians if coordinates == "scene" else moved(gaussians, turn.inverse())
    baked = bake(gaussians, [CAMERA], gaussians.lights["p"], CURVES["standard"])
    placement = Placement(coordinates, turn)
    write_ply(tmp_path / "relightable.ply", shown, baked, placement, relightable=True)
    write_lights(shown.lights, coordinates, tmp_path)
    again = load_relightable(tmp_path / "relightable.ply")
    assert (again.has_point_sun, again.sharp, again.sun_bounce) == (True, 0.7, 0.1)
    first, second = (linear(each, each.lights["p"]) for each in (gaussians, again))
    tolerance = 0 if coordinates == "scene" else 0.02
    assert float((first - second).abs().quantile(0.98)) <= tolerance


def test_lights_without_a_sun_are_written_as_before(tmp_path):
    sky = LearnedSky(torch.zeros(4, 3))
    write_lights({"p": Light(torch.zeros(25, 3), sky)}, "scene", tmp_path)
    assert "sun" not in (tmp_path / "lights.json").read_text()
    assert '"version": 1' in (tmp_path / "lights.json").read_text()
    write_lights({"p": sunlight(30.0, 10.0)}, "scene", tmp_path)
    read = read_lights(tmp_path)["p"].point
    expected = sunlight(30.0, 10.0).point
    np.testing.assert_array_equal(read.direction, expected.direction)
    np.testing.assert_array_equal(read.irradiance, expected.irradiance)
