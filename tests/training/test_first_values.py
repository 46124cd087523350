"""The first light and albedo from photos whose brightness is known."""

import pytest
import torch
from support.settings import train_settings

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.training.first_values import (
    ALBEDO_RANGE,
    UNSEEN_SKY,
    shown_albedo,
    shown_radiance,
    with_first_values,
)
from r3gw.training.lights.free import first_free
from r3gw.training.photos import Photo

CAMERA = Camera(torch.eye(4, dtype=torch.float64), (30.0, 30.0, 16.0, 12.0), 32, 24)
PHOTOS = train_settings(init={"light_radiance": "photos"})


def photo(sky: int, foreground: int, sky_rows: int = 10, occluder_rows: int = 0) -> Photo:
    """Sky above, foreground below it, a white occluder at the bottom."""
    planes = torch.full((3, 24, 32), foreground, dtype=torch.uint8)
    is_sky = torch.zeros(24, 32, dtype=torch.bool)
    is_sky[:sky_rows] = True
    planes[:, :sky_rows] = sky
    is_valid = torch.ones_like(is_sky)
    if occluder_rows:
        is_valid[-occluder_rows:] = False
        planes[:, -occluder_rows:] = 255
    return Photo("a", CAMERA, planes, is_valid, is_sky)


def test_half_is_sky_and_half_is_what_stands_before_it_whatever_their_pixels():
    photos = [photo(204, 102, sky_rows=7), photo(153, 51, sky_rows=14)]
    expected = 0.5 * ((0.8 + 0.6) / 2 + (0.4 + 0.2) / 2)
    assert shown_radiance(photos) == pytest.approx(expected, abs=1e-4)


def test_channels_count_alike():
    one = photo(0, 0)
    one.planes[0] = 153
    assert shown_radiance([one]) == pytest.approx(0.2, abs=1e-4)


def test_occluders_and_photos_that_show_hardly_any_sky_do_not_count():
    plain = shown_radiance([photo(204, 102)])
    assert shown_radiance([photo(204, 102, occluder_rows=6)]) == plain
    little = photo(51, 102, sky_rows=6)  # 192 pixels
    assert shown_radiance([photo(204, 102), little]) == plain


def test_without_any_sky_it_is_taken_as_usual_and_without_foreground_refused():
    expected = 0.5 * (UNSEEN_SKY + 0.4)
    assert shown_radiance([photo(0, 102, sky_rows=0)]) == pytest.approx(expected, abs=1e-4)
    with pytest.raises(InputError, match="no training photo shows anything but sky"):
        shown_radiance([photo(204, 0, sky_rows=24)])


def test_only_settings_that_ask_for_it_change():
    given = train_settings(init={"light_radiance": 0.8})
    assert with_first_values(given, [photo(204, 102)]) == given
    shown = with_first_values(PHOTOS, [photo(204, 102)])
    assert shown.init.light_radiance == pytest.approx(0.6, abs=1e-4)
    expected = given.model_copy(update={"init": shown.init})
    assert shown == expected


def test_surfaces_look_as_bright_as_the_photos_under_the_first_light():
    """The display curve is a power of 2.2."""
    expected = (188 / 255) ** 2.2 / 0.8
    assert shown_albedo([photo(204, 188)], 0.8) == pytest.approx(expected, abs=1e-4)
    dark, white = photo(204, 5), photo(204, 255)
    assert (shown_albedo([dark], 0.8), shown_albedo([white], 0.8)) == ALBEDO_RANGE


def test_albedo_follows_the_light_that_the_photos_show():
    asked = train_settings(init={"light_radiance": "photos", "albedo": "photos"})
    init = with_first_values(asked, [photo(204, 102)]).init
    assert init.light_radiance == pytest.approx(0.6, abs=1e-4)
    assert init.albedo * init.light_radiance == pytest.approx(0.4**2.2, abs=1e-4)


def test_a_model_is_not_built_from_a_light_that_is_not_settled():
    with pytest.raises(ValueError, match="must be settled"):
        first_free(PHOTOS)
