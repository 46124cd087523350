"""EXIF orientation of masks, against OpenCV's handling of the photo itself."""

import cv2
import numpy as np
import pytest
from support.exif import with_orientation

from r3gw.files import InputError
from r3gw.imaging.decode import read_picture
from r3gw.imaging.files import read_rgb
from r3gw.importing.reconstruction.orientation import upright_mask


@pytest.mark.parametrize("orientation", [5, 6, 7, 8])
def test_a_mask_of_the_stored_pixels_turns_with_its_photo(tmp_path, orientation):
    stored = np.zeros((32, 48), np.uint8)
    stored[:8, :16] = 255
    with_orientation(tmp_path / "photo.jpg", stored, orientation)
    cv2.imwrite(str(tmp_path / "mask.png"), stored)
    upright = read_rgb(tmp_path / "photo.jpg")[..., 0] >= 128
    assert upright.shape == (48, 32)
    mask = upright_mask(tmp_path / "mask.png", read_picture(tmp_path / "photo.jpg")).is_white
    assert np.array_equal(mask, upright)


def test_a_mask_of_the_upright_photo_stays(tmp_path):
    with_orientation(tmp_path / "photo.jpg", np.zeros((32, 48), np.uint8), 6)
    upright = np.zeros((48, 32), np.uint8)
    upright[:8, :16] = 255
    cv2.imwrite(str(tmp_path / "mask.png"), upright)
    mask = upright_mask(tmp_path / "mask.png", read_picture(tmp_path / "photo.jpg")).is_white
    assert np.array_equal(mask, upright >= 128)


@pytest.mark.parametrize("shape", [(32, 48), (20, 20)])
def test_a_mask_of_another_size_is_refused(tmp_path, shape):
    cv2.imwrite(str(tmp_path / "photo.jpg"), np.zeros((48, 32), np.uint8))  # no EXIF
    cv2.imwrite(str(tmp_path / "mask.png"), np.zeros(shape, np.uint8))
    with pytest.raises(InputError, match="but its photo is 32x48 px; make the mask again"):
        upright_mask(tmp_path / "mask.png", read_picture(tmp_path / "photo.jpg"))
