"""The mask stage on a scene in the NeRF-OSR layout: chains of sources, checks, what it writes."""

import json

import numpy as np
import pytest
from support import dots, nerf_osr_layout

from r3gw.files import InputError
from r3gw.files.strict import validated
from r3gw.imaging.files import read_grey, read_rgb, write_image
from r3gw.importing.settings import ColmapScene, NerfOsrScene
from r3gw.importing.stage import import_scene
from r3gw.masks.folder import load_masks
from r3gw.masks.settings import MaskSources
from r3gw.masks.stage import make_masks
from r3gw.scene import Points, save_points

GIVEN = MaskSources(sky_masks="given")
ROWS, COLUMNS = np.mgrid[:48, :64]


@pytest.fixture
def imported(tmp_path):
    place = nerf_osr_layout.build(tmp_path / "place")
    settings = NerfOsrScene(format="nerf-osr", path=".")
    scene = import_scene("place", settings, place.folder, tmp_path / "scene", num_threads=1)
    return scene, tmp_path / "scene", tmp_path / "masks"


def overwrite(folder, kind, name, is_white):
    write_image(folder / "given" / kind / f"{name}.png", np.asarray(is_white, np.bool_))


def without_points(folder):
    """The layout's points lie anywhere, those in the sky included."""
    save_points(Points(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint8)), folder)


def views_of(target):
    return json.loads((target / "masks.json").read_text())["views"]


def test_given_masks_keep_their_meaning(imported):
    scene, folder, target = imported
    make_masks(folder, target, GIVEN)
    for view in scene.views:
        is_valid, is_sky = load_masks(target, view)
        assert np.array_equal(is_valid, COLUMNS < 56)
        assert np.array_equal(is_sky, ROWS < 16)
    record = views_of(target)[scene.views[0].name]
    share = pytest.approx(1 / 3, abs=1e-6, rel=0)
    assert record["is_sky"] == {"source": "given", "share": share, "polarity": "upright"}
    assert record["is_valid"] == {"source": "given", "share": 0.875}


def test_missing_sky_mask_is_an_error_or_made(imported):
    scene, folder, target = imported
    without_points(folder)
    name = scene.views[0].name
    (folder / "given" / "is_sky" / f"{name}.png").unlink()
    with pytest.raises(InputError, match=f"{name}: no source of 'given' has .*-or-classical"):
        make_masks(folder, target, GIVEN)
    assert not (target / "masks.json").exists()
    make_masks(folder, target, MaskSources(sky_masks="given-or-classical"))
    is_sky = load_masks(target, scene.views[0])[1]
    # The photo's upper third is a plain blue above noise.
    truth = ROWS < 16
    assert (is_sky & truth).sum() / (is_sky | truth).sum() > 0.9
    assert views_of(target)[name]["is_sky"]["source"] == "classical"
    assert views_of(target)[scene.views[1].name]["is_sky"]["source"] == "given"
    make_masks(folder, target, MaskSources(sky_masks="given-or-none"))
    assert not load_masks(target, scene.views[0])[1].any()


def test_missing_occluder_mask_is_an_error_or_all_valid(imported):
    scene, folder, target = imported
    name = scene.views[0].name
    (folder / "given" / "is_valid" / f"{name}.png").unlink()
    with pytest.raises(InputError, match=f"{name}: .* mask is_valid .*-or-all"):
        make_masks(folder, target, MaskSources(valid_masks="given"))
    make_masks(folder, target, MaskSources())
    assert load_masks(target, scene.views[0])[0].all()
    assert views_of(target)[name]["is_valid"] == {"source": "all", "share": 1.0}


@pytest.mark.slow
def test_classical_ignores_given_sky(imported):
    scene, folder, target = imported
    overwrite(folder, "is_sky", scene.views[0].name, ROWS < 0)
    without_points(folder)
    make_masks(folder, target, MaskSources(sky_masks="classical"))
    assert load_masks(target, scene.views[0])[1].any()


@pytest.mark.slow
def test_points_say_what_is_no_sky(imported):
    scene, folder, target = imported
    make_masks(folder, target, MaskSources(sky_masks="classical"))
    assert not load_masks(target, scene.views[0])[1].any()  # points lie all over its blue third


def test_mask_of_another_size_is_refused(imported):
    scene, folder, target = imported
    overwrite(folder, "is_sky", scene.views[1].name, np.zeros((10, 20)))
    with pytest.raises(InputError, match="the mask is 20x10 px but its photo is 64x48 px"):
        make_masks(folder, target, GIVEN)


def test_black_sky_mask_is_a_warning(imported, caplog):
    scene, folder, target = imported
    overwrite(folder, "is_sky", scene.views[0].name, ROWS < 0)
    make_masks(folder, target, GIVEN)
    said = f"is_sky of {scene.views[0].name} (given) is without any sky"
    assert said in caplog.text
    assert said in json.loads((target / "masks.json").read_text())["warnings"][0]


def test_white_sky_mask_is_refused(imported):
    scene, folder, target = imported
    overwrite(folder, "is_sky", scene.views[0].name, ROWS >= 0)
    with pytest.raises(InputError, match=f"is_sky of {scene.views[0].name} .*every pixel is sky"):
        make_masks(folder, target, GIVEN)


def test_black_occluder_mask_is_refused(imported):
    scene, folder, target = imported
    overwrite(folder, "is_valid", scene.views[0].name, ROWS < 0)
    with pytest.raises(InputError, match=r"every pixel is an occluder.*white must mean valid"):
        make_masks(folder, target, GIVEN)
    assert not (target / "masks.json").exists()


def test_inverted_sky_masks_are_refused_and_a_single_one_is_a_warning(imported, caplog):
    scene, folder, target = imported
    overwrite(folder, "is_sky", scene.views[0].name, ROWS >= 16)
    make_masks(folder, target, GIVEN)
    assert f"is_sky of {scene.views[0].name} (given) has more sky in its lower" in caplog.text
    for view in scene.views:
        overwrite(folder, "is_sky", view.name, ROWS >= 16)
    with pytest.raises(InputError, match=r"4 of 4 sky masks .* look inverted"):
        make_masks(folder, target, GIVEN)


def test_inverted_occluder_masks_are_a_warning(imported, caplog):
    scene, folder, target = imported
    for view in scene.views:
        overwrite(folder, "is_valid", view.name, COLUMNS >= 56)
    make_masks(folder, target, GIVEN)
    assert "only 12% of the pixels of 4 occluder masks are valid" in caplog.text


def test_grey_given_masks_become_binary(imported):
    scene, folder, target = imported
    soft = np.tile(np.arange(0, 192, 4, dtype=np.uint8)[::-1, None], (1, 64))
    write_image(folder / "given" / "is_sky" / f"{scene.views[0].name}.png", soft)
    make_masks(folder, target, GIVEN)
    path = target / "is_sky" / f"{scene.views[0].name}.png"
    assert set(np.unique(read_grey(path))) == {0, 255}
    assert np.array_equal(read_grey(path) == 255, soft >= 128)


def test_label_maps_of_the_data_and_of_the_entry(imported, tmp_path):
    scene, folder, target = imported
    colours = np.array([(70, 130, 180), (0, 0, 142), (70, 70, 70)], np.uint8)
    came = colours[np.where(ROWS < 20, 0, 2)]
    own = colours[np.where(ROWS < 10, 0, np.where(COLUMNS < 8, 1, 2))]
    for view in scene.views:
        write_image(folder / "given" / "labels" / f"{view.name}.png", came)
    write_image(tmp_path / "labels" / f"{scene.views[0].name.upper()}.PNG", own)
    chains = {"sky_masks": "labels-or-given", "valid_masks": "labels"}
    sources = MaskSources(**chains, label_maps=str(tmp_path / "labels"))
    make_masks(folder, target, sources)
    is_valid, is_sky = load_masks(target, scene.views[0])
    assert np.array_equal(is_sky, ROWS < 10)
    assert np.array_equal(is_valid, (ROWS < 10) | (COLUMNS >= 8))
    assert np.array_equal(load_masks(target, scene.views[1])[1], ROWS < 20)
    assert views_of(target)[scene.views[1].name]["is_sky"]["source"] == "labels"
    with pytest.raises(InputError, match="no such folder; correct 'label_maps'"):
        make_masks(folder, target, MaskSources(label_maps=str(tmp_path / "nowhere")))


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"sky_masks": "given-or-clasical"}, "'clasical' is no source of masks; join given, "),
        ({"sky_masks": "classical-or-given"}, "nothing after 'classical' would ever be used"),
        ({"valid_masks": "given-or-classical"}, "'classical' is no source of masks"),
        ({"valid_masks": "network-or-all"}, "the entry names none: 'network'"),
        ({"network": {"model": "a.onnx"}}, "'network.sky' is missing"),
    ],
)
def test_wrong_chain_is_one_sentence(values, said):
    with pytest.raises(InputError, match=said):
        validated(MaskSources, values, "config")


def imported_with(tmp_path, change):
    place = nerf_osr_layout.build(tmp_path / "place")
    change(place.undistorted)
    settings = NerfOsrScene(format="nerf-osr", path=".")
    scene = import_scene("place", settings, place.folder, tmp_path / "scene", num_threads=1)
    return scene.views[0], tmp_path / "scene", tmp_path / "masks"


def test_transparent_pixels_are_neither_valid_nor_sky(tmp_path):
    stem = nerf_osr_layout.STEMS[0]

    def make_transparent(undistorted):
        (photo,) = (undistorted / "images").glob(f"{stem}.*")
        alpha = np.where(ROWS < 8, 0, 255)[..., None].astype(np.uint8)
        rgba = np.concatenate([read_rgb(photo), alpha], axis=2)
        photo.unlink()
        write_image(photo.with_suffix(".png"), rgba)

    view, folder, target = imported_with(tmp_path, make_transparent)
    make_masks(folder, target, GIVEN)
    is_valid, is_sky = load_masks(target, view)
    assert np.array_equal(is_valid, (COLUMNS < 56) & (ROWS >= 8))
    assert np.array_equal(is_sky, (ROWS < 16) & (ROWS >= 8))
    record = views_of(target)[view.name]["is_valid"]
    assert record == {
        "source": "given",
        "share": pytest.approx(0.875 * 5 / 6, abs=1e-6, rel=0),
        "transparent": pytest.approx(1 / 6, abs=1e-6, rel=0),
    }


def test_dark_mask_is_refused_with_the_range_of_its_values(tmp_path):
    stem = nerf_osr_layout.STEMS[0]

    def darken(undistorted):
        (mask,) = (undistorted / "masks").glob(f"{stem}.*")
        mask.unlink()
        write_image(mask.with_suffix(".png"), np.where(COLUMNS < 56, 38, 0).astype(np.uint8))

    _, folder, target = imported_with(tmp_path, darken)
    sentence = r"\(given, values from 0 to 38, white begins at 128\): every pixel is an occluder"
    with pytest.raises(InputError, match=sentence):
        make_masks(folder, target, GIVEN)


def test_photos_of_a_rig_get_the_masks_and_labels_of_their_own_paths(tmp_path):
    """Equal stems in several folders: masks by path, label maps by path or by the view's name."""
    names = [f"{side}/{number}.png" for side in ("left", "right") for number in (1, 2)]
    dots.colmap(tmp_path / "rig", names=names)
    width, height = dots.SIZE
    column, row = np.meshgrid(np.arange(width), np.arange(height))
    for number, name in enumerate(names):
        write_image(tmp_path / "rig" / "masks" / name, column >= 10 * (number + 1))
        labels = np.where(row < 20 * (number + 1), 23, 11).astype(np.uint8)
        path = "left_1.png" if number == 0 else name
        write_image(tmp_path / "labels" / path, labels)
    settings = ColmapScene(format="colmap", path=".")
    scene = import_scene("rig", settings, tmp_path / "rig", tmp_path / "scene", num_threads=1)
    sources = MaskSources(
        sky_masks="labels", label_maps=str(tmp_path / "labels"), label_classes="cityscapes-ids"
    )
    make_masks(tmp_path / "scene", tmp_path / "masks", sources)
    for number, view in enumerate(scene.views):
        is_valid, is_sky = load_masks(tmp_path / "masks", view)
        assert np.array_equal(is_valid, column >= 10 * (number + 1))
        assert np.array_equal(is_sky, row < 20 * (number + 1))
