"""The doctor on good scenes and on scenes with one thing wrong each."""

import json
import subprocess
import sys

import cv2
import layout_a
import numpy as np
import pytest
import yaml

from r3gw.doctor import examine
from r3gw.gaussians.stage import run_initialise
from r3gw.imaging.files import read_rgb, write_image
from r3gw.masks import make_masks
from r3gw.scene import load_scene, save_scene
from r3gw.settings import Config, MaskSources, NerfOsrScene, run_settings
from r3gw.sfm import import_scene

FULL = {
    "variants": ["full"],
    "seeds": [0, 1],
    "ablations": {"variants": ["no_specular"], "seeds": [0]},
    "train": {"iterations": 1000},
}


class Patient:
    """A configuration of one scene in layout A, with everything made that the doctor looks at."""

    def __init__(self, folder, defaults):
        self.folder, self.defaults = folder, defaults
        self.place = layout_a.build(folder / "place")
        self.entry = {"format": "nerf-osr", "path": str(self.place.folder)}
        self.results = folder / "results"
        self.scene = self.results / "place" / "scene"
        self.masks = self.results / "place" / "masks"

    def values(self):
        return FULL | {"scenes": {"place": self.entry}}

    def make(self):
        """Import, masks and initial points."""
        settings = NerfOsrScene(**self.entry)
        import_scene("place", settings, self.place.folder, self.scene, num_threads=1)
        make_masks(self.scene, self.masks, MaskSources())
        names = ("train", "variants")
        files = {f"{name}_file": self.defaults / f"{name}.yaml" for name in names}
        sky = run_settings(Config.model_validate(self.values()), "full", 0, **files).sky
        run_initialise(self.scene, sky, self.results / "place" / "initial.npz")

    def examine(self):
        path = self.folder / "mine.yaml"
        path.write_text(yaml.safe_dump(self.values()))
        target = self.folder / "doctor"
        return examine(path, self.results, target, defaults=self.defaults)


@pytest.fixture
def patient(tmp_path, repository):
    return Patient(tmp_path, repository / "config")


@pytest.fixture
def made(patient):
    patient.make()
    return patient


def facts(patient):
    return json.loads((patient.folder / "doctor" / "doctor.json").read_text())["place"]["facts"]


def test_page_of_a_good_scene(made):
    diagnosis = made.examine()
    assert diagnosis.problems == ()
    assert "Nothing stands in the way" in diagnosis.text
    assert (made.folder / "doctor" / "doctor.md").read_text() == diagnosis.text
    found = facts(made)
    assert found["photos"] == "4 (3 training, 1 test)"
    assert found["sizes"] == "64x48 px (4)"
    assert found["registered"] == "cameras came with the data"
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


def test_page_before_the_import(patient):
    diagnosis = patient.examine()
    assert diagnosis.problems == ()
    assert "views with an environment map | 1" in diagnosis.text
    assert "| not yet |" in diagnosis.text
    assert (patient.folder / "doctor" / "doctor.json").is_file()


def env_map(patient, shape):
    for path in (patient.place.eval_files / "ENV_MAP_CC").rglob("envmap.jpg"):
        layout_a.picture(path, np.zeros((*shape, 3), np.uint8))


def drop_photo(patient):
    next((patient.place.undistorted / "images").iterdir()).unlink()


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
        "no building is named 'castle'; there are: chapel",
    ),
}


@pytest.mark.parametrize("name", BROKEN_SOURCES)
def test_broken_source_is_a_problem_before_the_import(patient, name):
    spoil, said = BROKEN_SOURCES[name]
    assert patient.examine().problems == ()
    spoil(patient)
    (problem,) = patient.examine().problems
    assert said in problem
    assert not (patient.folder / "doctor" / "doctor.json").exists()


@pytest.mark.parametrize("count", [1, 2])
def test_one_photo_is_too_few(patient, tmp_path, count):
    for number in range(count):
        write_image(tmp_path / "few" / f"{number}.jpg", np.zeros((48, 64, 3), np.uint8))
    write_image(tmp_path / "few" / "masks" / "0.png", np.zeros((48, 64), np.uint8))
    patient.entry = {"format": "photos", "path": str(tmp_path / "few")}
    (problem,) = patient.examine().problems
    assert f"few: {count} photo{'s are' if count > 1 else ' is'} here, but at least 3" in problem


def edit_views(patient, change):
    scene = load_scene(patient.scene)
    views = tuple(change(number, view) for number, view in enumerate(scene.views))
    save_scene(scene.model_copy(update={"views": views}), patient.scene)


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


def test_black_evaluation_mask_and_narrow_map_are_problems(made):
    (view,) = load_scene(made.scene).split("test")
    write_image(made.scene / view.evaluation.mask, np.zeros((48, 64), np.uint8))
    (problem,) = made.examine().problems
    assert "evaluation mask" in problem
    assert "all black" in problem
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
    monkeypatch.setattr("r3gw.doctor.training.physical_memory_mb", lambda: 100.0)
    (problem,) = made.examine().problems
    assert "this machine has 0.1 GB; lower 'max_image_px'" in problem


def test_wrong_settings_are_a_problem(patient):
    patient.values = lambda: (
        FULL
        | {
            "scenes": {"place": patient.entry},
            "train": {"iteratoins": 7},
        }
    )
    problems = patient.examine().problems
    assert "unknown key 'iteratoins'; did you mean 'iterations'?" in problems[0]


def test_command_exits_with_one_line_per_problem(patient, tmp_path, repository):
    patient.entry["path"] = "nowhere"
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(patient.values()))
    arguments = ["--config", "mine.yaml", "--target", "page"]
    arguments += ["--defaults", str(repository / "config")]
    done = subprocess.run(
        [sys.executable, "-m", "r3gw", "doctor", *arguments],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.strip().splitlines() == [
        "r3gw doctor: nowhere: no such file or folder; correct 'path' of scene 'place'"
    ]
    assert "A run would fail. 1 problem, 0 warnings." in done.stdout
    assert (tmp_path / "page" / "doctor.md").is_file()


def command(*arguments):
    line = [sys.executable, "-m", "r3gw", *arguments]
    return subprocess.run(line, capture_output=True, text=True, check=False)


def test_gate_before_the_import(patient, tmp_path):
    target = tmp_path / "checked.json"
    wanted = ["check-source", "--scene", "place", "--target", str(target), "--entry"]
    assert command(*wanted, json.dumps(patient.entry)).returncode == 0
    assert json.loads(target.read_text())["problems"] == []
    target.unlink()
    done = command(*wanted, json.dumps(patient.entry | {"path": "nowhere"}))
    assert done.returncode == 1
    assert done.stderr.startswith("r3gw doctor: nowhere: no such file or folder")
    assert not target.exists()


def test_gate_before_the_training(made, tmp_path):
    target = tmp_path / "checked.json"
    wanted = ["check-scene", "--scene", "place", "--results", str(made.results)]
    assert command(*wanted, "--target", str(target)).returncode == 0
    assert json.loads(target.read_text())["facts"]["polarity"] == "4 upright"
    target.unlink()
    (made.masks / "is_sky" / f"{load_scene(made.scene).views[0].name}.png").unlink()
    done = command(*wanted, "--target", str(target))
    assert done.returncode == 1
    assert "no such picture" in done.stderr
    assert not target.exists()
