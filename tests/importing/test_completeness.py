"""Missing files are named before anything is read."""

import shutil

import pytest
from support import nerf_osr_layout

from r3gw.files import InputError
from r3gw.importing.completeness import missing_files, require_complete
from r3gw.importing.settings import NerfOsrScene, PhotosScene


@pytest.fixture
def place(tmp_path):
    return nerf_osr_layout.build(tmp_path / "place")


def missing(place, given=(), **changes):
    return missing_files(NerfOsrScene(format="nerf-osr", path=".", **changes), place.folder, given)


def test_a_complete_scene_lacks_nothing(place):
    assert missing(place, ["is_sky"], evaluated_views=[nerf_osr_layout.TEST_STEM]) == []


def test_every_missing_file_is_named(place):
    (place.undistorted / "images" / f"{nerf_osr_layout.STEMS[0]}.jpg").unlink()
    (place.undistorted / "images" / f"{nerf_osr_layout.STEMS[1]}.JPG").unlink()
    (place.undistorted / "sky_masks" / f"{nerf_osr_layout.STEMS[2]}.png").unlink()
    (place.undistorted / "sparse" / "0" / "points3D.bin").unlink()
    shutil.rmtree(place.eval_files / "eval_mask")
    assert missing(place, ["is_sky"]) == [
        "undistorted/sparse/0/{cameras,images,points3D}.bin or .txt",
        f"undistorted/images/{nerf_osr_layout.STEMS[0]}.jpg",
        f"undistorted/images/{nerf_osr_layout.STEMS[1]}.jpg",
        f"undistorted/sky_masks/{nerf_osr_layout.STEMS[2]}.png",
        f"eval_files: /home/author/data/eval_mask/{nerf_osr_layout.TEST_STEM}.png",
    ]
    # The mask stage can make sky masks, so they are needed only when asked for.
    assert not [name for name in missing(place) if "sky_masks" in name]


def test_test_views_of_the_paper_need_photo_and_entry(place):
    absent = "29-07_20_30_IMG_5607"
    assert missing(
        place, evaluated_views=[nerf_osr_layout.TEST_STEM, absent, nerf_osr_layout.STEMS[0]]
    ) == [
        f"undistorted/images/{absent}.jpg",
        f"entry of {absent} in eval_files/test_config.py",
        f"entry of {nerf_osr_layout.STEMS[0]} in eval_files/test_config.py",
    ]


def test_one_sentence_names_them_all(place):
    for path in (place.undistorted / "images").iterdir():
        path.unlink()
    settings = NerfOsrScene(format="nerf-osr", path=".")
    with pytest.raises(InputError, match=r"4 files are missing for scene 'lk2'") as caught:
        require_complete("lk2", settings, place.folder)
    assert all(stem in str(caught.value) for stem in nerf_osr_layout.STEMS)


def test_absent_folder(tmp_path):
    for settings in (
        NerfOsrScene(format="nerf-osr", path="."),
        PhotosScene(format="photos", path="."),
    ):
        with pytest.raises(InputError, match="no such file or folder; correct 'path' of scene 'x'"):
            require_complete("x", settings, tmp_path / "absent")
