"""The doctor on good scenes and on scenes with one thing wrong each."""

import json

import cv2
import numpy as np
import pytest
from support import nerf_osr_layout
from support.configured_scene import FULL, edit_views

from r3gw.imaging.files import read_rgb, write_image
from r3gw.scene import load_scene


def facts(configured):
    return json.loads((configured.folder / "doctor" / "doctor.json").read_text())["place"]["facts"]


def test_page_of_a_good_scene(made):
    diagnosis = made.examine()
    assert diagnosis.problems == ()
    assert "Nothing stands in the way" in diagnosis.text
    assert (made.folder / "doctor" / "doctor.md").read_text() == diagnosis.text
    found = facts(made)
    assert found["photos"] == "4 (3 training, 1 test)"
    assert found["sizes"] == "64x48 px (4)"
    assert found["registered"] == "4 of 4"
    assert found["sessions"] == "3: 01-08_07_30 (2), 02-08_12_00 (1), 03-08_18_00 (1)"
    assert found["sky masks"] == "4 given; cover 33% (33% to 33%)"
    assert found["polarity"] == "4 upright"
    assert found["sky visible"] == "in 4 of 4 photos"
    assert found["valid pixels"] == "4 given; cover 88% (88% to 88%)"
    assert found["environment maps"] == "found for 1 of 1 test views"
    assert "(30 foreground, " in found["Gaussians"]
    assert found["time"].endswith("for all 2")
    picture = read_rgb(made.folder / "doctor" / "place_up.png")
    assert (np.abs(picture.astype(int) - (255, 0, 140)).sum(axis=-1) < 30).sum() > 100


def test_page_before_the_import(configured):
    diagnosis = configured.examine()
    assert diagnosis.problems == ()
    assert "views with an environment map | 1" in diagnosis.text
    assert "| not yet |" in diagnosis.text
    assert (configured.folder / "doctor" / "doctor.json").is_file()


def env_map(configured, shape):
    for path in (configured.place.eval_files / "ENV_MAP_CC").rglob("envmap.jpg"):
        nerf_osr_layout.picture(path, np.zeros((*shape, 3), np.uint8))


def drop_photo(configured):
    next((configured.place.undistorted / "images").iterdir()).unlink()


BROKEN_SOURCES = {
    "photo": (drop_photo, "one file is missing for scene 'place'"),
    "env map": (lambda p: env_map(p, (16, 30)), "30x16 px; an equirectangular map"),
    "labels": (lambda p: p.entry.update(label_maps="nowhere"), "nowhere: no such folder"),
    "network": (
        lambda p: p.entry.update(sky_masks="network", network={"model": "none.onnx", "sky": [1]}),
        "none.onnx: no such network",
    ),
    "folder": (lambda p: p.entry.update(path="nowhere"), "nowhere: no such file or folder"),
    "building": (
        lambda p: p.entry.update(format="synthetic", building="castle") or p.entry.pop("path"),
        "scene 'place': no building is named 'castle'; there are: chapel",
    ),
}


@pytest.mark.parametrize("name", BROKEN_SOURCES)
def test_broken_source_is_a_problem_before_the_import(configured, name):
    spoil, said = BROKEN_SOURCES[name]
    assert configured.examine().problems == ()
    spoil(configured)
    (problem,) = configured.examine().problems
    assert said in problem
    assert not (configured.folder / "doctor" / "doctor.json").exists()


@pytest.mark.parametrize("count", [1, 2])
def test_one_photo_is_too_few(configured, tmp_path, count):
    for number in range(count):
        write_image(tmp_path / "few" / f"{number}.jpg", np.zeros((48, 64, 3), np.uint8))
    write_image(tmp_path / "few" / "masks" / "0.png", np.zeros((48, 64), np.uint8))
    configured.entry = {"format": "photos", "path": str(tmp_path / "few")}
    (problem,) = configured.examine().problems
    found = "one photo is" if count == 1 else "2 photos are"
    assert f"few: {found} here, but at least 3" in problem


def upside_down(view):
    turned = np.array(view.cam_from_world) @ np.diag([-1.0, -1.0, 1.0, 1.0])
    return view.model_copy(update={"cam_from_world": tuple(map(tuple, turned.tolist()))})


def test_one_training_photo_is_too_few(made):
    edit_views(made, lambda n, v: v.model_copy(update={"split": "train" if n == 0 else "test"}))
    assert any("only 1 training photo is left" in problem for problem in made.examine().problems)


def test_world_upside_down_is_a_problem(made):
    edit_views(made, lambda _, view: upside_down(view))
    (problem,) = made.examine().problems
    assert "in 4 of 4 photos the sky lies below the rest" in problem


def test_masks_of_an_earlier_import_are_a_problem(made):
    edit_views(made, lambda n, v: v.model_copy(update={"name": "new"}) if n == 0 else v)
    assert any(
        "lacks new; run the mask stage again" in problem for problem in made.examine().problems
    )


@pytest.mark.parametrize("white_px", [0, 4])
def test_evaluation_mask_that_leaves_nothing_is_a_problem(made, white_px):
    (view,) = load_scene(made.scene).split("test")
    mask = np.zeros((48, 64), np.uint8)
    mask[20 : 20 + white_px, 20 : 20 + white_px] = 255
    write_image(made.scene / view.evaluation.mask, mask)
    (problem,) = made.examine().problems
    assert f"the evaluation mask of {view.name} is all black once eroded by 5x5 px" in problem
    mask[20:25, 20:25] = 255
    write_image(made.scene / view.evaluation.mask, mask)
    assert made.examine().problems == ()


def test_broken_and_foreign_photos_are_problems(made):
    first, second, *_ = load_scene(made.scene).views
    (made.scene / first.image).write_bytes(b"no picture")
    write_image(made.scene / second.image, np.zeros((40, 64, 3), np.uint8))
    unreadable, foreign = made.examine().problems
    assert f"{first.image}: not a readable picture" in unreadable
    assert f"{second.image}: 64x40 px, but scene.json says 64x48 px" in foreign


def test_map_turned_about_y_is_a_problem(made):
    def turned(_, view):
        if view.evaluation is None:
            return view
        entry = view.evaluation.model_copy(update={"rotation_rad": (-1.5, 0.2, 0.0)})
        return view.model_copy(update={"evaluation": entry})

    edit_views(made, turned)
    (problem,) = made.examine().problems
    assert "initial_env_map_rotation has y=0.2 and z=0" in problem


def test_narrow_map_is_a_problem(made):
    (view,) = load_scene(made.scene).split("test")
    env = made.scene / view.evaluation.env_map
    assert cv2.imwrite(str(env), np.zeros((16, 30, 3), np.uint8))
    (problem,) = made.examine().problems
    assert "must be twice as wide as high" in problem


def test_all_problems_of_all_scenes_are_told(made):
    made.entry["label_maps"] = "nowhere"
    (made.masks / "masks.json").unlink()
    (made.results / "place" / "initial.npz").unlink()
    problems = made.examine().problems
    assert len(problems) == 3
    assert not (made.folder / "doctor" / "doctor.json").exists()


def test_too_little_memory_is_a_problem(made, monkeypatch):
    monkeypatch.setattr("r3gw.pipeline.doctor.training.physical_memory_mb", lambda: 100.0)
    (problem,) = made.examine().problems
    assert "this machine has 0.1 GB; lower 'max_image_px'" in problem


def test_wrong_settings_are_a_problem(configured):
    configured.values = lambda: (
        FULL
        | {
            "scenes": {"place": configured.entry},
            "train": {"iteratoins": 7},
        }
    )
    problems = configured.examine().problems
    assert "unknown key 'iteratoins'; did you mean 'iterations'?" in problems[0]
