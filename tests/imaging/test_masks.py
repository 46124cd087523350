"""Masks of every depth and with their shape in alpha mean the same."""

import cv2
import numpy as np
import pytest
from PIL import Image

from r3gw.imaging.masks import read_mask, read_mask_levels

MASK = np.random.default_rng(2).random((9, 13)) > 0.5


def saved(path, values):
    assert cv2.imwrite(str(path), values)
    return path


@pytest.mark.parametrize(
    ("dtype", "white", "suffix"),
    [
        (np.uint8, 255, ".png"),
        (np.uint8, 1, ".png"),
        (np.uint16, 65535, ".png"),
        (np.uint16, 1, ".png"),
        (np.uint16, 255, ".png"),
        (np.uint16, 65535, ".tif"),
        (np.float32, 1.0, ".tif"),
        (np.uint8, 1, ".bmp"),
    ],
)
def test_white_is_the_upper_half_of_the_range(tmp_path, dtype, white, suffix):
    values = MASK.astype(dtype) * dtype(white)
    assert np.array_equal(read_mask(saved(tmp_path / f"g{suffix}", values), 13, 9), MASK)
    if dtype != np.float32:
        colour = np.repeat(values[..., None], 3, axis=2)
        assert np.array_equal(read_mask(saved(tmp_path / f"c{suffix}", colour)), MASK)


@pytest.mark.parametrize("value", [0, 1, 255])
def test_plain_masks(tmp_path, value):
    path = saved(tmp_path / "a.png", np.full((4, 5), value, np.uint8))
    assert (read_mask(path) == (value > 0)).all()


@pytest.mark.parametrize("colour", [(255, 255, 255), (0, 0, 0), (200, 30, 30)])
@pytest.mark.parametrize("elsewhere", [(0, 0, 0), (255, 255, 255)])
def test_shape_in_alpha(tmp_path, colour, elsewhere):
    rgba = np.empty((9, 13, 4), np.uint8)
    rgba[..., :3] = np.where(MASK[..., None], colour, elsewhere)
    rgba[..., 3] = np.where(MASK, 255, 0)
    Image.fromarray(rgba).save(tmp_path / "a.png")
    assert np.array_equal(read_mask(tmp_path / "a.png"), MASK)


def test_opaque_alpha_says_nothing_and_a_painted_mask_loses_what_is_transparent(tmp_path):
    rgba = np.dstack([np.repeat(np.where(MASK, 255, 0)[..., None], 3, 2), np.full((9, 13), 255)])
    Image.fromarray(rgba.astype(np.uint8)).save(tmp_path / "a.png")
    assert np.array_equal(read_mask(tmp_path / "a.png"), MASK)
    rgba[:4, :, 3] = 0
    Image.fromarray(rgba.astype(np.uint8)).save(tmp_path / "b.png")
    expected = MASK.copy()
    expected[:4] = False
    assert np.array_equal(read_mask(tmp_path / "b.png"), expected)


def test_range_is_told(tmp_path):
    levels = read_mask_levels(saved(tmp_path / "a.png", MASK.astype(np.uint8) * 38))
    assert levels.described() == "values from 0 to 38, white begins at 128"
    assert not levels.is_white.any()
