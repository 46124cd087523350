"""The mask stage on a scene with given masks, and the sky segmentation on made pictures."""

import json

import cv2
import layout_a
import numpy as np
import pytest

from r3gw.files import InputError
from r3gw.imaging.files import read_grey, write_image
from r3gw.masks import load_masks, make_masks, segment_sky
from r3gw.settings import NerfOsrScene
from r3gw.sfm import import_scene


@pytest.fixture
def imported(tmp_path):
    place = layout_a.build(tmp_path / "place")
    settings = NerfOsrScene(format="nerf-osr", path=".")
    scene = import_scene("place", settings, place.folder, tmp_path / "scene", num_threads=1)
    return scene, tmp_path / "scene", tmp_path / "masks"


def test_given_masks_keep_their_meaning(imported):
    scene, folder, target = imported
    make_masks(folder, target, sky="given")
    y, x = np.mgrid[:48, :64]
    for view in scene.views:
        is_valid, is_sky = load_masks(target, view)
        assert np.array_equal(is_valid, x < 56)
        assert np.array_equal(is_sky, y < 16)
    report = json.loads((target / "masks.json").read_text())["views"][scene.views[0].name]
    assert report["is_sky"] == {"source": "given", "share": pytest.approx(1 / 3, abs=1e-6, rel=0)}
    assert report["is_valid"] == {"source": "given", "share": 0.875}


def test_missing_masks_are_made_or_refused(imported):
    scene, folder, target = imported
    name = scene.views[0].name
    (folder / "given" / "is_sky" / f"{name}.png").unlink()
    (folder / "given" / "is_valid" / f"{name}.png").unlink()
    with pytest.raises(InputError, match=f"no sky mask for {name}; .* given-or-classical"):
        make_masks(folder, target, sky="given")
    assert not (target / "masks.json").exists()
    make_masks(folder, target, sky="given-or-classical")
    is_valid, is_sky = load_masks(target, scene.views[0])
    assert is_valid.all()
    # The photo's upper third is a plain blue above noise.
    truth = np.mgrid[:48, :64][0] < 16
    assert (is_sky & truth).sum() / (is_sky | truth).sum() > 0.9
    views = json.loads((target / "masks.json").read_text())["views"]
    assert views[name]["is_sky"]["source"] == "classical"
    assert views[name]["is_valid"]["source"] == "all"
    assert views[scene.views[1].name]["is_sky"]["source"] == "given"


def test_classical_ignores_given_sky(imported):
    scene, folder, target = imported
    path = folder / "given" / "is_sky" / f"{scene.views[0].name}.png"
    write_image(path, np.zeros((48, 64), np.uint8))
    make_masks(folder, target, sky="classical")
    assert load_masks(target, scene.views[0])[1].any()


def test_wrong_size_and_uniform_masks(imported, caplog):
    scene, folder, target = imported
    sky = folder / "given" / "is_sky"
    write_image(sky / f"{scene.views[0].name}.png", np.zeros((48, 64), np.uint8))
    make_masks(folder, target, sky="given")
    assert f"is_sky of {scene.views[0].name} is without any sky" in caplog.text
    write_image(sky / f"{scene.views[1].name}.png", np.zeros((10, 20), np.uint8))
    with pytest.raises(InputError, match="the mask is 20x10 px but its photo is 64x48 px"):
        make_masks(folder, target, sky="given")


def test_grey_given_masks_become_binary(imported):
    scene, folder, target = imported
    soft = np.tile(np.arange(0, 256, 4, dtype=np.uint8), (48, 1))
    write_image(folder / "given" / "is_sky" / f"{scene.views[0].name}.png", soft)
    make_masks(folder, target, sky="given")
    path = target / "is_sky" / f"{scene.views[0].name}.png"
    assert set(np.unique(read_grey(path))) == {0, 255}
    assert np.array_equal(read_grey(path) == 255, soft >= 128)


def made_photo(sky_rgb, wall_rgb, size=(300, 400), seed=0):
    """A gabled house with stones and a tree, under a sky with a soft gradient; and the sky."""
    rng = np.random.default_rng(seed)
    height, width = size
    y, x = np.mgrid[:height, :width] / height
    house = (y > 0.35) & (abs(x - 0.6) < 0.35) | (abs(x - 0.6) < (y - 0.12) * 1.5) & (y < 0.36)
    tree = (x - 1.15) ** 2 + (y - 0.6) ** 2 < 0.02
    ground = y > 0.8
    photo = np.array(sky_rgb) * (0.9 + 0.1 * y[..., None])
    stones = cv2.resize(rng.uniform(0.7, 1.1, (30, 40)), (width, height), interpolation=0)
    photo[house] = (np.array(wall_rgb) * stones[..., None])[house]
    photo[tree] = rng.uniform(0.3, 1, (height, width, 1))[tree] * (30, 60, 20)
    photo[ground] = (np.array((110, 105, 95)) * stones[..., None])[ground]
    photo += rng.normal(0, 2, photo.shape)
    return np.clip(photo, 0, 255).astype(np.uint8), ~(house | tree | ground)


@pytest.mark.parametrize(
    ("sky_rgb", "wall_rgb"),
    [
        ((120, 160, 220), (190, 170, 140)),  # fair day
        ((225, 228, 232), (150, 148, 142)),  # overcast, grey stone
        ((60, 90, 160), (235, 233, 230)),  # white stone, darker than the sky is bright
        ((90, 90, 100), (70, 55, 45)),  # dusk
    ],
)
def test_sky_of_a_made_photo(sky_rgb, wall_rgb):
    photo, truth = made_photo(sky_rgb, wall_rgb)
    found = segment_sky(photo)
    assert found.shape == truth.shape
    assert (found & truth).sum() / (found | truth).sum() > 0.97


@pytest.mark.parametrize("size", [(150, 200), (900, 1200)])
def test_sky_of_small_and_large_photos(size):
    photo, truth = made_photo((120, 160, 220), (190, 170, 140), size)
    found = segment_sky(photo)
    assert (found & truth).sum() / (found | truth).sum() > 0.97


@pytest.mark.parametrize("hard", [0, 70])  # pixels from the left whose edge is hard
def test_cloud_on_a_blue_sky_is_sky(hard):
    photo, truth = made_photo((60, 100, 190), (150, 130, 105))
    y, x = np.mgrid[:300, :400]
    cloud = np.exp(-(((x - 60) / 60) ** 4) - ((y - 160) / 50) ** 4)
    cloud = np.where(x < hard, cloud > 0.5, cloud)[..., None] * truth[..., None]
    photo = (photo * (1 - cloud) + 250 * cloud).astype(np.uint8)
    found = segment_sky(photo)
    assert (found & truth).sum() / (found | truth).sum() > 0.97


def test_same_photo_gives_the_same_mask():
    photo, _ = made_photo((120, 160, 220), (190, 170, 140))
    assert np.array_equal(segment_sky(photo), segment_sky(photo))


def test_photo_without_anything_smooth_has_no_sky():
    photo = np.random.default_rng(0).integers(0, 255, (120, 160, 3), dtype=np.uint8)
    assert not segment_sky(photo).any()
