"""r3gw.relight.lights and tone: blends, yaw, the sun's place, exposure, curves by hand."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
import torch

from r3gw.files import InputError
from r3gw.imaging.files import write_exr
from r3gw.lighting import envmap
from r3gw.lighting.irradiance import irradiance
from r3gw.lighting.skies import MapSky
from r3gw.relight import tone
from r3gw.relight.gaussians import relightable_of
from r3gw.relight.lights import LightOptions, MapSource, PhotoSource, SunSource, light_over_time
from r3gw.relight.sweep import Sweep


def test_blend_ends_at_the_two_lights(tiny):
    gaussians = relightable_of(tiny.model)
    options = LightOptions(PhotoSource(("a_0", "a_1"), Sweep((0.0, 1.0))))
    at = light_over_time(gaussians, options)
    for time, photo in ((0.0, "a_0"), (1.0, "a_1")):
        expected, found = gaussians.lights[photo], at(time)
        torch.testing.assert_close(found.sh, expected.sh, rtol=0, atol=0)
        torch.testing.assert_close(
            found.sky_coefficients, expected.sky_coefficients, rtol=0, atol=0
        )
    half = 0.5 * (gaussians.lights["a_0"].sh + gaussians.lights["a_1"].sh)
    torch.testing.assert_close(at(0.5).sh, half, rtol=1e-6, atol=1e-6)


def test_yaw_is_the_map_rolled(tiny, tmp_path):
    env_map = np.random.default_rng(0).random((16, 32, 3), dtype=np.float32)
    write_exr(tmp_path / "map.exr", env_map)
    write_exr(tmp_path / "rolled.exr", np.roll(env_map, 8, axis=1))  # a quarter to the right
    gaussians = relightable_of(tiny.model)
    options = LightOptions(MapSource(tmp_path / "map.exr"), yaw_deg=Sweep((90.0,)))
    turned = light_over_time(gaussians, options)(0.0)
    rolled = light_over_time(gaussians, LightOptions(MapSource(tmp_path / "rolled.exr")))(0.0)
    torch.testing.assert_close(turned.sh, rolled.sh, rtol=1e-5, atol=1e-5)
    looks = torch.nn.functional.normalize(torch.randn(3000, 3), dim=-1)
    seen, expected = (s.sky.radiance(looks) for s in (turned, rolled))
    torch.testing.assert_close(seen, expected, rtol=0, atol=1e-3)


def test_a_map_shows_each_pixel_in_its_direction():
    env_map = torch.rand(16, 32, 3, generator=torch.Generator().manual_seed(0))
    looks = envmap.pixel_directions(16, 32).float()
    torch.testing.assert_close(MapSky(env_map).radiance(looks), env_map, rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("elevation", "azimuth", "towards"),
    [
        (0.5, 0.0, (0.0, 0.0, 1.0)),
        (0.5, 90.0, (1.0, 0.0, 0.0)),
        (45.0, 180.0, (0.0, -0.7071, -0.7071)),
        (90.0, 0.0, (0.0, -1.0, 0.0)),
    ],
)
def test_the_sun_stands_where_asked(tiny, elevation, azimuth, towards):
    sun = SunSource(Sweep((elevation,)), Sweep((azimuth,)))
    light = light_over_time(relightable_of(tiny.model), LightOptions(sun))(0.0)
    looks = torch.nn.functional.normalize(
        torch.randn(40000, 3, generator=torch.Generator().manual_seed(0)), dim=-1
    )
    brightest = looks[light.sky.radiance(looks).sum(-1).argmax()]
    assert float(brightest @ torch.tensor(towards)) > np.cos(radians(4.0))
    # Surfaces that face the sun receive the most; the blue sky draws a low sun's peak upwards.
    warmest = looks[irradiance(light.sh, looks)[:, 0].argmax()]
    assert float(warmest @ torch.tensor(towards)) > np.cos(radians(35.0))


def test_auto_exposure_gives_the_learned_strength(tiny):
    gaussians = relightable_of(tiny.model)
    sun = SunSource(Sweep((5.0, 60.0, 5.0)), Sweep((90.0, 270.0)))
    at = light_over_time(gaussians, LightOptions(sun))
    learned = torch.stack([light.sh[0].mean() for light in gaussians.lights.values()]).median()
    torch.testing.assert_close(at(0.5).sh[0].mean(), learned, rtol=1e-5, atol=0)
    assert at(0.0).sh[0].mean() < 0.7 * learned  # mornings are darker
    with pytest.raises(InputError, match="give a factor"):
        light_over_time(replace(gaussians, lights={}), LightOptions(sun, exposure="auto"))


def test_tone_curves_by_hand():
    at = torch.tensor([0.18, 1.0, 4.0])
    reinhard = tone.reinhard(at) ** 2.2  # x (1 + x / 16) / (1 + x)
    torch.testing.assert_close(reinhard, torch.tensor([0.154258, 0.53125, 1.0]), rtol=0, atol=1e-5)
    filmic = tone.filmic(at)[0] ** 2.2  # 0.086724 / 0.324932
    torch.testing.assert_close(filmic, torch.tensor(0.266899), rtol=0, atol=1e-5)
    torch.testing.assert_close(tone.standard(at) ** 2.2, at.clamp(max=1.0), rtol=1e-5, atol=0)
    torch.testing.assert_close(tone.linear_from_scene(tone.scene_linear(at)), at, rtol=1e-5, atol=0)


def test_sweeps():
    assert [Sweep.parse("10:60:10").at(s) for s in (0.0, 0.25, 0.5, 1.0)] == [10, 35, 60, 10]
    assert not Sweep.parse("7").moves
    with pytest.raises(InputError, match="'a:3' is neither"):
        Sweep.parse("a:3")
