"""r3gw.evaluation.gallery: the map turns with its light, learned lights are the learned ones."""

import json

import numpy as np
import pytest
import torch
from support.tiny import opacities

from r3gw.evaluation.gallery import light_picture, write_gallery
from r3gw.geometry.cameras import pixel_rays
from r3gw.imaging.files import read_rgb
from r3gw.lighting import sh
from r3gw.model.lights import photo_light
from r3gw.relight.gaussians import relightable_of
from r3gw.relight.uncovered import other_sky_seen, own_sky_behind
from r3gw.relight.witnesses import Witnesses


@torch.no_grad()
def layers(tiny, view: str) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Opacities of foreground and sky in a view, and what photos saw as dark: ``[H, W, 1]``."""
    camera = tiny.view(view).camera
    photos = [tiny.view(name).camera for name in ("a_0", "a_1")]
    dark = Witnesses(relightable_of(tiny.model), photos).darkness(camera)
    return *opacities(tiny.model, camera), dark


@pytest.fixture(scope="module")
def gallery(tiny, tmp_path_factory):
    """The gallery of the tiny scene."""
    folder = tmp_path_factory.mktemp("gallery")
    write_gallery(tiny.evaluated, folder)
    return folder


def test_unturned_true_map_gives_the_photo(tiny, gallery):
    shown = json.loads((gallery / "relit.json").read_text())
    assert shown["views"] == ["b_exact", "c_swept"]
    assert shown["yaws_deg"] == list(range(0, 360, 15))
    photo = read_rgb(tiny.folder / "images" / "b_exact.png")
    foreground, sky, dark = layers(tiny, "b_exact")
    # The sky is white, in the photo in place of the sky's Gaussians alone.
    expected = photo + 255 * (other_sky_seen(foreground, sky, dark) - sky).numpy()
    assert shown["map"] == "true map of b"  # its sun makes it the most directional
    picture = read_rgb(gallery / "map" / "b_exact_000.png")
    np.testing.assert_allclose(picture, expected, rtol=0, atol=1.1)
    turned = read_rgb(gallery / "map" / "b_exact_180.png").astype(int)
    assert np.abs(turned[20:] - photo[20:]).mean() > 5


def test_thumbnail_turns_to_the_right(gallery):
    first, quarter = (read_rgb(gallery / "map" / f"light_{yaw:03d}.png") for yaw in (0, 90))
    np.testing.assert_array_equal(quarter, np.roll(first, first.shape[1] // 4, axis=1))


def test_learned_lights_come_from_one_photo_per_session(tiny, gallery):
    shown = json.loads((gallery / "relit.json").read_text())
    assert shown["photos"] == ["a_0"]  # both training photos are of session a
    view = tiny.view("c_swept")
    light = photo_light(tiny.model, "a_0")
    looks = torch.nn.functional.normalize(pixel_rays(view.camera), dim=-1)  # it is not turned
    behind = (sh.radiance(light.sky_coefficients, looks) + 0.5).clamp(0.0, 1.0).numpy()
    weight = own_sky_behind(*layers(tiny, "c_swept")).numpy()
    expected = tiny.evaluated.render(view, light) + weight * behind
    picture = read_rgb(gallery / "learned" / "c_swept_0.png")
    np.testing.assert_allclose(picture, 255 * expected, rtol=0, atol=0.52)


def test_light_picture_is_white_at_its_brightest():
    grey = torch.full((16, 32, 3), 0.2)
    grey[0] = 0.8
    picture = light_picture(grey)
    assert picture.shape == (64, 128, 3)
    assert picture[0].min() == 255
    expected = 255 * (0.2 / 0.8) ** (1 / 2.2)
    np.testing.assert_allclose(picture[40], expected, rtol=0, atol=1)
