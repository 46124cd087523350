"""Names of views and who belongs to whom."""

import unicodedata

import pytest

from r3gw.files import InputError
from r3gw.scene.names import ByPhoto, key_of, normalised, stem_of, view_names


@pytest.mark.parametrize(
    ("written", "key"),
    [
        ("IMG_1.JPG", "img_1"),
        ("./left\\IMG_1.jpeg", "left/img_1"),
        ("a.b.c.png", "a.b.c"),
        ("v1.2", "v1.2"),
        ("photo.jpg.png", "photo.jpg"),
        ("cafe\u0301.heic", "caf\u00e9"),
        ("left/.png", "left/.png"),
    ],
)
def test_keys(written, key):
    assert key_of(written) == key


def test_stems_keep_their_case_and_are_composed():
    assert stem_of("x/Fac\u0327ade.v2.TIF") == "Façade.v2"
    assert unicodedata.is_normalized("NFC", normalised("e\u0301/e\u0301.png"))


def test_unique_stems_are_the_names():
    paths = ["b/x 1.jpg", "a/y.final.png"]
    assert view_names(paths) == {"b/x 1.jpg": "x 1", "a/y.final.png": "y.final"}


def test_equal_stems_are_told_apart_by_what_their_paths_do_not_share():
    paths = ["rig/left/0001.jpg", "rig/right/0001.jpg", "rig/right/0002.jpg"]
    assert list(view_names(paths).values()) == ["left_0001", "right_0001", "right_0002"]


def test_names_are_unique_and_safe_whatever_the_paths():
    paths = ["a_b/c.jpg", "a/b_c.jpg", "A/b_c.png", 'a/b:*?"<>|c.jpg', "a/b\x07c.jpg", "c.jpg"]
    paths += [f"{'long ' * 60}{number}/c.jpg" for number in range(2)]
    names = view_names(paths)
    assert len({name.lower() for name in names.values()}) == len(paths)
    for name in names.values():
        assert not set(name) & set('/\\:*?"<>|\x07')
        assert len(name.encode()) < 200


def matched(things, photos):
    found = ByPhoto({thing: thing for thing in things}, photos, "masks")
    return {photo: found.get(photo) for photo in photos}, found.unused


def test_a_thing_belongs_to_the_photo_of_its_path():
    photos = ["left/1.jpg", "right/1.jpg", "2.jpg"]
    found, unused = matched(["LEFT/1.png", "rig/right/1.png", "any/where/2.png", "3.png"], photos)
    assert found == {"left/1.jpg": "LEFT/1.png", "right/1.jpg": "rig/right/1.png",
                     "2.jpg": "any/where/2.png"}  # fmt: skip
    assert unused == ["3.png"]


def test_another_folder_of_equal_stems_is_not_taken_for_it():
    found, unused = matched(["left/1.png"], ["left/1.jpg", "right/1.jpg"])
    assert found == {"left/1.jpg": "left/1.png", "right/1.jpg": None}
    assert not unused


def test_a_single_stem_is_found_across_folders():
    found, _ = matched(["people/1.png"], ["day/1.jpg", "day/2.jpg"])
    assert found == {"day/1.jpg": "people/1.png", "day/2.jpg": None}


def test_the_exact_path_comes_before_a_longer_one():
    found, _ = matched(["1.png", "left/1.png"], ["1.jpg", "left/1.jpg"])
    assert found == {"1.jpg": "1.png", "left/1.jpg": "left/1.png"}


@pytest.mark.parametrize(
    ("things", "photos", "sentence"),
    [
        (["1.png"], ["left/1.jpg", "right/1.jpg"], "masks: 1.png fits several photos"),
        (["1.png", "1.jpg"], ["1.jpg"], "masks: 1.png is for the same photo as 1.jpg"),
    ],
)
def test_what_could_mean_several_is_refused(things, photos, sentence):
    with pytest.raises(InputError, match=sentence):
        matched(things, photos)
