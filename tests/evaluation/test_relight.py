"""r3gw.evaluation.relight and lights: maps turn the right way, names are checked."""

from math import pi

import numpy as np
import pytest
import torch

from r3gw.evaluation.lights import map_light, photo_light
from r3gw.evaluation.relight import relight_view
from r3gw.files import InputError
from r3gw.imaging.files import read_rgb, write_exr, write_image
from r3gw.lighting import envmap, sh


def test_map_light_is_linear_and_yaw_turns_to_the_right(tmp_path):
    env_map = np.random.default_rng(0).random((16, 32, 3), dtype=np.float32)
    write_exr(tmp_path / "map.exr", env_map)
    write_exr(tmp_path / "rolled.exr", np.roll(env_map, 4, axis=1) * np.float32(2.5))
    turned = map_light(tmp_path / "map.exr", 4, yaw_rad=2 * pi * 4 / 32, exposure=2.5)
    torch.testing.assert_close(turned, map_light(tmp_path / "rolled.exr", 4), rtol=1e-5, atol=1e-5)


def test_display_maps_are_made_linear(tmp_path):
    write_image(tmp_path / "grey.png", np.full((32, 64, 3), 128, np.uint8))
    light = map_light(tmp_path / "grey.png", 2)
    expected = torch.full((3,), (128 / 255) ** 2.2)
    seen = sh.radiance(light, torch.tensor([0.0, 0.0, 1.0]))
    torch.testing.assert_close(seen, expected, rtol=0.01, atol=0)


def test_relit_under_the_true_map_equals_the_photo(tiny, tmp_path):
    scaled = tiny.env_map * 0.8 * torch.tensor([1.1, 1.0, 0.9])
    write_exr(tmp_path / "map.exr", scaled.numpy())
    out = tmp_path / "out.png"
    relight_view(tiny.model_path, tiny.folder, "b_exact", out, env_map=tmp_path / "map.exr")
    photo = read_rgb(tiny.folder / "images" / "b_exact.png").astype(int)
    assert np.abs(read_rgb(out) - photo).max() <= 1


def test_a_photos_light_brings_its_sky(tiny, tmp_path):
    def picture(name: str, **how) -> np.ndarray:
        relight_view(tiny.model_path, tiny.folder, "a_1", tmp_path / name, **how)
        return read_rgb(tmp_path / name).astype(int)

    photo = read_rgb(tiny.folder / "images" / "a_1.png").astype(int)
    assert np.abs(picture("own.png", light_of="a_1") - photo).max() <= 1
    white = picture("white.png", light_of="a_1", sky="white")
    assert np.median(white[:8]) > 245
    other = picture("other.png", light_of="a_1", sky="learned:a_0")
    assert np.abs(other[20:] - photo[20:]).mean() < 1
    assert np.abs(other[:8] - white[:8]).mean() > 5


@pytest.mark.parametrize(
    ("view", "how", "message"),
    [
        ("a_0", {}, "either --env-map or --light-of"),
        ("a_9", {"light_of": "a_0"}, "has no view 'a_9'; it has a_0, a_1"),
        ("a_0", {"light_of": "a_9"}, "no light of a photo 'a_9'.*a_0, a_1"),
        ("a_0", {"light_of": "a_0", "sky": "blue"}, "sky 'blue' is unknown"),
    ],
)
def test_wrong_names_are_told(tiny, tmp_path, view, how, message):
    with pytest.raises(InputError, match=message):
        relight_view(tiny.model_path, tiny.folder, view, tmp_path / "o.png", **how)


def test_learned_light_is_the_networks(tiny):
    light, _ = photo_light(tiny.model, "a_0")
    torch.testing.assert_close(light, tiny.model.appearance(0)[0].detach(), rtol=0, atol=0)
    assert not light.requires_grad
    assert envmap.draw(light, 8).shape == (8, 16, 3)
