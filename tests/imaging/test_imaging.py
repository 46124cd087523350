"""Pictures on disk against OpenCV, Pillow-free JPEG facts and closed forms; masks; the curve."""

import cv2
import numpy as np
import pytest
import torch

from r3gw.files import InputError
from r3gw.imaging.colour import (
    DARKEST,
    display_array_from_linear,
    display_from_linear,
    linear_from_display,
)
from r3gw.imaging.files import read_grey, read_linear, read_rgb, write_exr, write_image
from r3gw.imaging.masks import erode, read_mask, resize_mask


def test_display_is_the_gamma_of_the_clamped_light():
    linear = torch.tensor([0.0, 0.25, 0.5, 1.0, 4.0], dtype=torch.float64)
    expected = np.array([DARKEST, 0.25, 0.5, 1.0, 1.0]) ** (1 / 2.2)
    np.testing.assert_allclose(display_from_linear(linear), expected, rtol=1e-12, atol=0)
    inside = torch.linspace(0.01, 1.0, 50, dtype=torch.float64)
    np.testing.assert_allclose(
        linear_from_display(display_from_linear(inside)), inside, rtol=1e-12, atol=0
    )
    np.testing.assert_allclose(
        display_array_from_linear(np.array([-1.0, 0.25, 2.0])),
        [0.0, 0.25 ** (1 / 2.2), 1.0],
        rtol=1e-6,
        atol=0,
    )


def test_clamped_light_keeps_only_gradients_that_lead_back():
    for target, moves in ((0.2, True), (2.0, False)):
        linear = torch.tensor([3.0], requires_grad=True)
        ((display_from_linear(linear) - target) ** 2).sum().backward()
        assert bool(linear.grad.abs() > 0) is moves


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_colours_keep_their_order(tmp_path, suffix):
    image = np.zeros((16, 24, 3), np.uint8)
    image[:] = (200, 100, 50)
    write_image(tmp_path / f"a{suffix}", image)
    assert np.abs(read_rgb(tmp_path / f"a{suffix}").astype(int) - image).max() <= 2
    assert cv2.imread(str(tmp_path / f"a{suffix}"))[0, 0, 0] == pytest.approx(50, abs=2, rel=0)


@pytest.mark.parametrize("progressive", [0, 1])
def test_cut_off_jpeg_is_refused_however_it_is_wrapped(tmp_path, progressive):
    image = np.random.default_rng(0).integers(0, 255, (40, 60, 3), dtype=np.uint8)
    options = [cv2.IMWRITE_JPEG_PROGRESSIVE, progressive]
    whole = cv2.imencode(".jpg", image, options)[1].tobytes()
    thumbnail = cv2.imencode(".jpg", image[::4, ::4])[1].tobytes()
    segment = b"\xff\xe1" + (2 + len(thumbnail)).to_bytes(2, "big") + thumbnail
    wrapped = whole[:2] + segment + whole[2:]
    path = tmp_path / "a.jpg"
    # A phone appends a film, whose bytes may look like markers.
    for data in (whole, wrapped, wrapped + b"\xff\xda\xff\xd8film"):
        path.write_bytes(data)
        assert read_rgb(path).shape == (40, 60, 3)
    for data in (whole, wrapped):
        for share in (0.3, 0.6, 0.95):
            path.write_bytes(data[: int(len(data) * share)])
            with pytest.raises(InputError, match=r"a\.jpg: not a readable picture"):
                read_rgb(path)


def test_exr_round_trip_is_exact_and_nan_is_refused(tmp_path):
    image = np.random.default_rng(0).normal(size=(5, 7, 3)).astype(np.float32) * 1e4
    write_exr(tmp_path / "a.exr", image)
    assert np.array_equal(read_linear(tmp_path / "a.exr"), image)
    image[0, 0, 0] = np.nan
    write_exr(tmp_path / "b.exr", image)
    with pytest.raises(InputError, match=r"b\.exr: holds NaN"):
        read_linear(tmp_path / "b.exr")


@pytest.mark.parametrize("name", ["none.png", "none.exr", "none.hdr"])
def test_missing_picture_is_named(tmp_path, name):
    with pytest.raises(InputError, match=f"{name}: no such picture"):
        (read_rgb if name.endswith("png") else read_linear)(tmp_path / name)


def test_text_is_no_picture(tmp_path):
    for name, read in (("a.png", read_rgb), ("b.png", read_grey), ("c.exr", read_linear)):
        (tmp_path / name).write_text("not a picture")
        with pytest.raises(InputError, match=f"{name}: not a readable"):
            read(tmp_path / name)


def test_mask_round_trip_and_size(tmp_path):
    mask = np.random.default_rng(1).random((9, 13)) > 0.5
    write_image(tmp_path / "m.png", mask)
    assert np.array_equal(read_mask(tmp_path / "m.png", 13, 9), mask)
    with pytest.raises(InputError, match="the mask is 13x9 px but its photo is 9x13 px"):
        read_mask(tmp_path / "m.png", 9, 13)


def test_resize_and_erosion_of_a_half_plane():
    mask = np.zeros((40, 60), np.bool_)
    mask[:, 30:] = True
    assert np.array_equal(resize_mask(mask, 30, 20), np.mgrid[:20, :30][1] >= 15)
    assert np.array_equal(erode(mask, 5), np.mgrid[:40, :60][1] >= 32)
