"""Exposure and white balance of photos: what they mean, and that training finds the true ones."""

import copy
import math
from dataclasses import replace
from math import pi

import pytest
import torch
from support.settings import train_settings

from r3gw.imaging.colour import GAMMA
from r3gw.lighting import sh
from r3gw.lighting.gains import sky_with_gains
from r3gw.model.appearance import Appearance
from r3gw.model.lights import photo_light, photographed_light
from r3gw.model.model import SceneModel
from r3gw.model.model_file import load_model, save_model
from r3gw.rendering.compose import render, shaded_splats
from r3gw.training.first_values import shown_gains
from r3gw.training.loop import train
from r3gw.training.losses.lighting import unlikeness
from r3gw.training.objective import objective
from r3gw.training.photos import Photo
from r3gw.training.schedule import Schedule
from r3gw.training.sun_shadows import SunShadows
from r3gw.training.visible_sky import visible_sky, without_gains

PHOTOS = ("p_0", "p_1", "p_2", "p_3")
GAINS = {"enabled": True, "steady": 0.002, "alike": 0.02, "warmth": 1.0}
# Of a phone in shade, a pink cast, a dark and a yellow photo.
CASTS = torch.tensor([[1.0, 1.0, 1.2], [1.25, 0.85, 1.1], [0.7, 0.7, 0.7], [1.1, 1.0, 0.7]])


def with_gains(tiny, share: bool) -> SceneModel:
    """The tiny model, its photos with gains; under one light where it is shared."""
    model = copy.deepcopy(tiny.model)
    description = model.description.model_copy(
        update={"photo_gains": True, "share_session_light": share}
    )
    rows = [0] * len(PHOTOS) if share else range(len(PHOTOS))
    generator = torch.Generator().manual_seed(2)
    appearance = Appearance(rows, description, model.appearance.light_model, generator)
    sessions = ("s",) * len(PHOTOS) if share else PHOTOS
    return SceneModel(description, model.foreground, model.sky, appearance, PHOTOS, sessions)


@torch.no_grad()
def cast_photos(tiny) -> list[Photo]:
    """The tiny model under its first light, photographed with `CASTS`."""
    lit = tiny.model.appearance(0)
    views = [tiny.view(name) for name in ("a_0", "a_1", "b_exact", "c_swept")]
    is_sky = torch.zeros(32, 48, dtype=torch.bool)
    is_sky[:14] = True
    photos = []
    for name, view, cast in zip(PHOTOS, views, CASTS, strict=True):
        light = 0.6 * lit.light * cast
        sky = sky_with_gains(lit.sky_light * 0.2, 0.6 * cast)
        colour = render(tiny.model, view.camera, light, sky).colour.clamp(0, 1)
        planes = (255 * colour).round().byte().permute(2, 0, 1).contiguous()
        photos.append(Photo(name, view.camera, planes, torch.ones_like(is_sky), is_sky))
    return photos


def test_gains_are_one_in_the_median_and_scale_what_is_seen(tiny):
    model = with_gains(tiny, share=False)
    appearance = model.appearance
    torch.testing.assert_close(appearance.gains(), torch.ones(4, 3), rtol=0, atol=0)
    with torch.no_grad():
        appearance.log_gains.copy_(CASTS.log() + 3.0)
        gains = appearance.gains()
        assert torch.equal(gains.median(dim=0).values, torch.ones(3))
        torch.testing.assert_close(gains[1] / gains[0], CASTS[1] / CASTS[0], rtol=1e-5, atol=0)
        scene, seen = appearance.scene_light(1), appearance(1)
        torch.testing.assert_close(seen.light, gains[1] * scene.light, rtol=1e-6, atol=0)
        up = torch.tensor([[0.0, -1.0, 0.0]])
        before = sh.radiance(scene.sky_light, up) + 0.5
        after = sh.radiance(seen.sky_light, up) + 0.5
    torch.testing.assert_close(after, before * gains[1] ** (1 / GAMMA), rtol=1e-5, atol=0)


def test_relighting_gets_the_light_without_the_camera(tiny, tmp_path):
    model = with_gains(tiny, share=True)
    with torch.no_grad():
        model.appearance.log_gains.copy_(CASTS.log())
    save_model(model, tmp_path / "model.safetensors")
    read = load_model(tmp_path / "model.safetensors")
    first, other = (photo_light(read, name) for name in ("p_0", "p_1"))
    torch.testing.assert_close(first.sh, other.sh, rtol=0, atol=0)
    torch.testing.assert_close(first.sky.coefficients, other.sky.coefficients, rtol=0, atol=0)
    ratio = photographed_light(read, "p_1").sh / photographed_light(read, "p_0").sh
    torch.testing.assert_close(ratio, (CASTS[1] / CASTS[0]).expand_as(ratio), rtol=1e-4, atol=0)


@pytest.mark.slow
def test_training_finds_the_casts_of_photos_of_one_light(tiny):
    """Within 3 %, from gains of 1, beside a light and a sky that are learned too."""
    settings = train_settings(
        iterations=400,
        gains=GAINS,
        model={"share_session_light": True},
        rates={"short_run_boost": 40.0},
        density={"last": 0},
    )
    state = train(with_gains(tiny, share=True), cast_photos(tiny), settings)
    found = state.model.appearance.gains().detach()
    found = found / found.log().mean(0).exp()
    true = CASTS / CASTS.log().mean(0).exp()
    torch.testing.assert_close(found, true, rtol=0.03, atol=0)
    assert any("loss_gains" in row for row in state.history.rows)


def test_gains_begin_where_photos_of_one_light_show_them(tiny):
    """By the photos' means alone: they show other parts of the wall, so within 15 %."""
    photos = cast_photos(tiny)
    found, true = shown_gains(photos, 1.0), CASTS / CASTS.median(dim=0).values
    torch.testing.assert_close(found, true, rtol=0.15, atol=0)
    assert torch.equal(found.median(dim=0).values, torch.ones(3))
    blind = replace(photos[1], is_valid=torch.zeros_like(photos[1].is_valid))
    assert torch.equal(shown_gains([photos[0], blind, photos[2]], 1.0)[1], torch.ones(3))


def test_a_sky_is_seen_without_the_camera_s_gains(tiny):
    photo = cast_photos(tiny)[1]
    sky = visible_sky(photo.camera, photo.planes, photo.is_sky)
    (plain, nothing) = without_gains([sky, None], torch.stack([CASTS[1], CASTS[2]]))
    torch.testing.assert_close(plain.radiance * CASTS[1], sky.radiance, rtol=1e-6, atol=0)
    assert torch.equal(plain.basis, sky.basis)
    assert nothing is None


def test_noise_is_on_the_light_before_the_camera(tiny, monkeypatch):
    """A photo of gains 1/25 gets 1/25 of the noise."""
    seen = []

    def noted(model, camera, light, *rest):
        seen.append(light.detach())
        return shaded_splats(model, camera, light, *rest)

    monkeypatch.setattr("r3gw.training.objective.shaded_splats", noted)
    settings = train_settings(gains=GAINS, model={"share_session_light": True})
    model, photo = with_gains(tiny, share=True), cast_photos(tiny)[0]
    for gain in (1.0, 0.04):
        with torch.no_grad():
            model.appearance.log_gains.zero_()
            model.appearance.log_gains[0] = math.log(gain)
            seen.append(model.appearance(0).light)
        generator = torch.Generator().manual_seed(3)
        schedule = Schedule.of(settings)
        objective(model, settings, photo, 0, 1, schedule, generator, SunShadows())
    noise, less = seen[1] - seen[0], seen[3] - seen[2]
    assert float(noise.std()) > 0.01
    torch.testing.assert_close(less, 0.04 * noise, rtol=1e-3, atol=1e-6)


def test_unlikeness_is_of_mean_radiance_alone():
    first = torch.randn(25, 3, generator=torch.Generator().manual_seed(0))
    first[0] = (4 * pi) ** 0.5
    second = first.clone()
    second[1:] += 1.0
    assert float(unlikeness(first, second, 1.0)) == 0
    second[0] *= torch.tensor([2.0, 1.0, 1.0])
    expected = torch.tensor(2.0).log().square()
    torch.testing.assert_close(unlikeness(first, second, 1.0), expected, rtol=1e-5, atol=0)


def test_lights_may_differ_in_warmth_and_not_in_tint_or_brightness():
    first = sh.constant(1.0, 4)
    warm, green, bright = (
        sh.constant(1.0, 4) * torch.tensor(factors)
        for factors in ([1.5, 1.0, 1 / 1.5], [1 / 1.5, 2.25, 1 / 1.5], [1.5, 1.5, 1.5])
    )
    step = math.log(1.5)
    assert float(unlikeness(first, warm, 0.0)) == pytest.approx(0, rel=0, abs=1e-10)
    assert float(unlikeness(first, warm, 0.25)) == pytest.approx(0.25 * 2 * step**2, rel=1e-4)
    assert float(unlikeness(first, green, 0.0)) == pytest.approx(6 * step**2, rel=1e-4)
    assert float(unlikeness(first, bright, 0.0)) == pytest.approx(3 * step**2, rel=1e-4)


def test_they_are_off_in_the_paper_s_settings(tiny):
    assert not train_settings().gains.enabled
    assert tiny.model.appearance.log_gains is None
    assert "appearance.log_gains" not in tiny.model.appearance.state_dict()
