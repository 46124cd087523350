"""The protocol half-image on photos that a known model made under lights that it never learned."""

import numpy as np
import pytest
import torch

from r3gw.evaluation.fitted_light import Target, fitted_light, times_gains
from r3gw.evaluation.protocols.half_image import HalfImage
from r3gw.imaging.colour import GAMMA
from r3gw.imaging.files import read_rgb, write_image
from r3gw.imaging.pictures import bytes_from_display
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.model.lights import photo_light


@pytest.fixture
def held_out(tiny):
    """A test view whose photo is lit as a learned light is, but for gains and some shape."""
    start = photo_light(tiny.model, "a_1")
    generator = torch.Generator().manual_seed(1)
    shape = 0.15 * start.strength * torch.randn(start.sh.shape, generator=generator)
    shape[9:] = 0  # what a diffuse wall shows of a light
    sky = LearnedSky(start.sky.coefficients + torch.tensor([[-0.4], [0.1], [0.1], [0.1]]))
    light = times_gains(Light(start.sh + shape, sky), torch.tensor([1.2, 0.9, 0.7]))
    view = tiny.view("c_swept").model_copy(update={"image": "images/held_out.png"})
    picture = tiny.evaluated.render(view, light)
    write_image(tiny.folder / view.image, bytes_from_display(picture))
    mask = tiny.masks / "is_valid" / "c_swept.png"
    before = read_rgb(mask)
    yield view
    write_image(mask, before)


def test_the_right_half_is_found_from_the_left(tiny, held_out):
    learned = tiny.evaluated.render(held_out, photo_light(tiny.model, "a_1"))
    photo = tiny.evaluated.photo(held_out)
    outcome = HalfImage().evaluate(tiny.evaluated, held_out)
    unfitted = -10 * np.log10(((learned - photo)[:, 24:] ** 2).mean())
    assert unfitted < 24
    assert outcome.figures["psnr"] > 32
    assert outcome.figures["psnr_foreground"] > 32
    assert outcome.figures["ssim"] > 0.95


def test_figures_are_of_the_right_half_alone(tiny, held_out):
    outcome = HalfImage().evaluate(tiny.evaluated, held_out)
    squared = (outcome.picture - tiny.evaluated.photo(held_out)) ** 2
    assert outcome.figures["mse"] == pytest.approx(squared[:, 24:].mean(), rel=1e-9, abs=0)
    lower = squared[14:, 24:].mean()  # sky is above
    expected = -10 * np.log10(lower + 1e-6)
    assert outcome.figures["psnr_foreground"] == pytest.approx(expected, rel=1e-9, abs=0)


def test_nothing_of_the_right_half_is_looked_at(tiny, held_out):
    before = HalfImage().evaluate(tiny.evaluated, held_out)
    path = tiny.folder / held_out.image
    pixels = read_rgb(path).copy()
    pixels[:, 24:] = 255 - pixels[:, 24:]
    write_image(path, pixels)
    after = HalfImage().evaluate(tiny.evaluated, held_out)
    np.testing.assert_array_equal(after.picture, before.picture)
    assert after.figures["psnr"] < 15


def test_what_is_not_valid_is_not_fitted_to(tiny, held_out):
    """A passer-by in the left half, marked, changes nothing."""
    mask = np.ones((32, 48), np.bool_)
    mask[16:, 4:12] = False
    write_image(tiny.masks / "is_valid" / "c_swept.png", mask)
    before = HalfImage().evaluate(tiny.evaluated, held_out)
    pixels = read_rgb(tiny.folder / held_out.image).copy()
    pixels[16:, 4:12] = (255, 0, 0)
    write_image(tiny.folder / held_out.image, pixels)
    after = HalfImage().evaluate(tiny.evaluated, held_out)
    np.testing.assert_array_equal(after.picture, before.picture)


@pytest.mark.parametrize("half", [slice(0, 24), slice(24, 48)])
def test_a_half_without_valid_pixels_is_not_scored(tiny, held_out, half):
    mask = np.ones((32, 48), np.bool_)
    mask[:, half] = False
    write_image(tiny.masks / "is_valid" / "c_swept.png", mask)
    assert HalfImage().evaluate(tiny.evaluated, held_out) is None


def test_the_model_is_left_as_it_was(tiny, held_out):
    rows = [*tiny.model.foreground.values.values(), *tiny.model.sky.rows.values.values()]
    before = [row.detach().clone() for row in rows]
    HalfImage().evaluate(tiny.evaluated, held_out)
    for row, value in zip(rows, before, strict=True):
        torch.testing.assert_close(row.detach(), value, rtol=0, atol=0)
        assert row.requires_grad


def test_gains_of_a_light_are_gains_of_the_picture(tiny):
    """Foreground and sky, where neither is clamped."""
    view, gains = tiny.view("a_0"), torch.tensor([0.8, 0.6, 0.9])
    light = photo_light(tiny.model, "a_0")
    flat = Light(light.sh, LearnedSky(light.sky.coefficients * 0.2))
    before = tiny.evaluated.render(view, flat)
    after = tiny.evaluated.render(view, times_gains(flat, gains))
    expected = before * gains.numpy() ** (1 / GAMMA)
    is_inside = (before < 0.999).all(axis=-1)
    assert is_inside.mean() > 0.9
    np.testing.assert_allclose(after[is_inside], expected[is_inside], rtol=2e-3, atol=2e-3)


def test_the_best_of_several_starts_is_taken(tiny):
    """From darkness alone the fit would stop elsewhere."""
    photo = torch.from_numpy(tiny.evaluated.photo(tiny.view("a_0"))).float()
    target = Target(tiny.view("a_0").camera, photo, torch.ones(32, 48, dtype=torch.bool))
    right = photo_light(tiny.model, "a_0")
    wrong = Light(-right.sh, right.sky)
    found = fitted_light(tiny.model, target, [wrong, right])
    picture = tiny.evaluated.render(tiny.view("a_0"), found)
    assert -10 * np.log10(((picture - photo.numpy()) ** 2).mean()) > 50
