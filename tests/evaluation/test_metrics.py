"""r3gw.evaluation.metrics against numbers worked out by hand and scikit-image's definitions."""

import numpy as np
import pytest

from r3gw.evaluation.metrics import evaluation_mask, masked_psnr, psnr_of_mse, score
from r3gw.files import InputError


def constant(value: float, height: int = 12, width: int = 16) -> np.ndarray:
    """A picture of one value, [H, W, 3]."""
    return np.full((height, width, 3), value)


def everywhere(height: int = 12, width: int = 16) -> np.ndarray:
    """A mask that counts all pixels."""
    return np.ones((height, width), np.bool_)


def test_constant_pictures_by_hand():
    scores = score(constant(0.5), constant(0.25), everywhere(), "v")
    # Variances are 0, so SSIM is (2ab + C1)/(a^2 + b^2 + C1) with C1 = 0.01^2.
    assert scores.ssim == pytest.approx(0.2501 / 0.3126, rel=1e-9, abs=0)
    assert scores.mse == pytest.approx(0.0625, rel=1e-12, abs=0)
    assert scores.mae == pytest.approx(0.25, rel=1e-12, abs=0)
    assert scores.psnr == pytest.approx(12.0411304, rel=0, abs=1e-6)


def test_equal_pictures_have_60_db():
    scores = score(constant(0.3), constant(0.3), everywhere(), "v")
    assert (scores.psnr, scores.ssim, scores.mse, scores.mae) == (60.0, 1.0, 0.0, 0.0)


def test_mse_by_hand_on_two_channels_of_two_pixels():
    picture, photo = constant(0.2), constant(0.2)
    is_scored = np.zeros((12, 16), np.bool_)
    is_scored[5, 5] = is_scored[5, 6] = True
    picture[5, 5, 0] = 0.5  # error 0.3
    picture[5, 6, 2] = 0.1  # error -0.1
    picture[0, 0] = 1.0  # not scored
    scores = score(picture, photo, is_scored, "v")
    assert scores.mse == pytest.approx((0.09 + 0.01) / 6, rel=1e-12, abs=0)
    assert scores.mae == pytest.approx(0.4 / 6, rel=1e-12, abs=0)
    # -10 log10(0.0166667 + 0.000001)
    assert scores.psnr == pytest.approx(17.7812523, rel=0, abs=1e-6)


def test_half_a_mask_does_not_raise_the_psnr():
    is_left = everywhere()
    is_left[:, 8:] = False
    whole = score(constant(0.6), constant(0.5), everywhere(), "v")
    half = score(constant(0.6), constant(0.5), is_left, "v")
    assert half.psnr == pytest.approx(whole.psnr, rel=1e-12, abs=0)


def test_ssim_averages_the_map_over_the_mask_only():
    rng = np.random.default_rng(0)
    photo = rng.random((12, 16, 3))
    picture = photo.copy()
    picture[:, 12:] = rng.random((12, 4, 3))
    is_far = everywhere()
    is_far[:, 9:] = False  # 3 px or more from the change: outside the 5 px window
    assert score(picture, photo, is_far, "v").ssim == pytest.approx(1.0, rel=1e-12, abs=0)
    assert score(picture, photo, ~is_far, "v").ssim < 0.8


def test_masked_psnr_agrees_with_score():
    rng = np.random.default_rng(1)
    picture, photo = rng.random((2, 12, 16, 3))
    is_scored = rng.random((12, 16)) < 0.5
    expected = score(picture, photo, is_scored, "v").psnr
    assert masked_psnr(picture, photo, is_scored, "v") == pytest.approx(expected, rel=1e-12, abs=0)


def test_empty_mask_is_an_error_that_names_the_view():
    empty = np.zeros((12, 16), np.bool_)
    with pytest.raises(InputError, match=r"'IMG_7'.*leaves no pixel"):
        score(constant(0.5), constant(0.5), empty, "IMG_7")
    with pytest.raises(InputError, match="leaves no pixel"):
        masked_psnr(constant(0.5), constant(0.5), empty, "IMG_7")


def test_evaluation_mask_is_resized_then_eroded_by_two_pixels_a_side():
    given = np.zeros((40, 60), np.bool_)
    given[10:30, 20:50] = True
    mask = evaluation_mask(given, width=30, height=20)
    expected = np.zeros((20, 30), np.bool_)
    expected[5 + 2 : 15 - 2, 10 + 2 : 25 - 2] = True
    np.testing.assert_array_equal(mask, expected)


def test_erosion_does_not_eat_the_frame():
    assert evaluation_mask(everywhere(), width=16, height=12).all()


def test_psnr_scale():
    assert psnr_of_mse(0.1 - 1e-6) == pytest.approx(10.0, rel=1e-12, abs=0)
