"""Label maps: Cityscapes colours and ids, and what is refused."""

import numpy as np
import pytest

from r3gw.files import InputError
from r3gw.imaging.files import write_image
from r3gw.masks.labels import read_label_masks
from r3gw.masks.settings import LabelClasses

# The picture: sky above; below, a building, a person and a tree side by side.
PARTS = np.zeros((30, 40), int)
PARTS[10:, :20], PARTS[10:, 20:30], PARTS[10:, 30:] = 1, 2, 3
# Sky, building, person, vegetation as data.md and Cityscapes write them.
COLOURS = np.array([(70, 130, 180), (70, 70, 70), (220, 20, 60), (107, 142, 35)], np.uint8)
IDS = {"cityscapes-ids": (23, 11, 24, 21), "cityscapes-train-ids": (10, 2, 11, 8)}


def test_colours(tmp_path):
    write_image(tmp_path / "a.png", COLOURS[PARTS])
    is_valid, is_sky = read_label_masks(tmp_path / "a.png", "cityscapes-colours", 40, 30)
    assert np.array_equal(is_sky, PARTS == 0)
    assert np.array_equal(is_valid, PARTS != 2)


@pytest.mark.parametrize("classes", sorted(IDS))
@pytest.mark.parametrize("channels", [1, 3])
def test_ids(tmp_path, classes, channels):
    labels = np.array(IDS[classes], np.uint8)[PARTS]
    write_image(tmp_path / "a.png", labels if channels == 1 else np.dstack([labels] * 3))
    is_valid, is_sky = read_label_masks(tmp_path / "a.png", classes, 40, 30)
    assert np.array_equal(is_sky, PARTS == 0)
    assert np.array_equal(is_valid, PARTS != 2)


def test_ids_of_ones_own(tmp_path):
    write_image(tmp_path / "a.png", (PARTS + 200).astype(np.uint8))
    classes = LabelClasses(sky=(200,), occluders=(202, 203))
    is_valid, is_sky = read_label_masks(tmp_path / "a.png", classes, 40, 30)
    assert np.array_equal(is_sky, PARTS == 0)
    assert np.array_equal(is_valid, PARTS < 2)


def test_larger_label_map_is_scaled_without_mixing_classes(tmp_path):
    large = COLOURS[PARTS].repeat(3, axis=0).repeat(3, axis=1)
    write_image(tmp_path / "a.png", large)
    is_valid, is_sky = read_label_masks(tmp_path / "a.png", "cityscapes-colours", 40, 30)
    assert np.array_equal(is_sky, PARTS == 0)
    assert np.array_equal(is_valid, PARTS != 2)


@pytest.mark.parametrize(
    ("pixels", "classes", "said"),
    [
        (COLOURS[PARTS], "cityscapes-ids", "of colours, not of ids"),
        (PARTS.astype(np.uint8), "cityscapes-colours", "of ids, not of Cityscapes colours"),
        (COLOURS[PARTS] + np.uint8(3), "cityscapes-colours", "only 0% .*without loss"),
        (COLOURS[PARTS][:15], "cityscapes-colours", "40x15 px but its photo is 40x30 px"),
        (COLOURS[PARTS][::2, ::2], "cityscapes-colours", "20x15 px but its photo is 40x30 px"),
    ],
)
def test_what_does_not_fit_is_one_sentence(tmp_path, pixels, classes, said):
    write_image(tmp_path / "a.png", np.ascontiguousarray(pixels))
    with pytest.raises(InputError, match=said):
        read_label_masks(tmp_path / "a.png", classes, 40, 30)
