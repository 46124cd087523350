"""The doctor looks before the work begins, and what it refuses does not start."""

import re

import pytest
from support.tiny_workflow import CONFIG, snakemake, started

from r3gw.pipeline.doctor.training import predicted, read_size
from r3gw.training.settings import load_train_settings

pytestmark = pytest.mark.slow


def test_doctor_looked_before_the_training(finished):
    page = (finished / "results/doctor/doctor.md").read_text()
    assert "Nothing stands in the way of a run." in page
    assert (finished / "results/doctor/tiny_up.png").is_file()
    assert (finished / "results/figures/tiny_masks.png").is_file()
    scene = finished / "results/tiny"
    run = scene / "full/seed0"
    made = [scene / "scene/scene.json", scene / "checked.json", run / "model.safetensors"]
    times = [path.stat().st_mtime_ns for path in made]
    assert times == sorted(times)


def test_the_scenes_gate_comes_before_its_trainings(finished):
    rules = [rule for rule, _ in started((finished / "all.log").read_text())]
    assert rules.index("import_scene") < rules.index("doctor_scene") < rules.index("train")


def test_a_training_asks_for_what_the_doctor_predicts(finished):
    done = snakemake(
        finished, "results/tiny/full/seed0/run.json", "--dry-run", "--forcerun", "train"
    )
    assert done.returncode == 0, done.stderr
    (asked,) = re.findall(r"resources: .*mem_mb=(\d+)", done.stdout + done.stderr)
    size = read_size(finished / "results/tiny/checked.json")
    settings = load_train_settings(finished / "results/tiny/full/seed0/settings.json")
    assert int(asked) == round(300 + 1.3 * predicted(settings, size).memory_mb)


def test_broken_source_of_one_scene_starts_no_other(untouched):
    castle = CONFIG["scenes"]["tiny"] | {"building": "castle"}
    wrong = CONFIG | {"scenes": CONFIG["scenes"] | {"wrong": castle}}
    done = snakemake(untouched, "--keep-going", "all", config=wrong)
    assert done.returncode != 0
    assert "r3gw doctor: scene 'wrong': no building is named 'castle'" in done.stderr
    assert "Traceback" not in done.stderr
    assert started(done.stderr) == []
    assert not (untouched / "results").exists()


def test_training_that_does_not_fit_stops_at_the_doctor(finished):
    density = {"density": {"max_gaussians": 10**11}}
    too_much = CONFIG | {"train": CONFIG["train"] | density}
    done = snakemake(finished, "results/tiny/no_specular/seed0/model.safetensors", config=too_much)
    assert done.returncode != 0
    assert "tiny/no_specular/seed0: a training will need about 100000.4 GB" in done.stderr
    assert "lower 'max_image_px' or 'density.max_gaussians'" in done.stderr
    assert [rule for rule, _ in started(done.stderr)] == ["write_settings", "train"]
    log = (finished / "logs/train/tiny.no_specular.seed0.log").read_text()
    assert log.splitlines() == [line for line in done.stderr.splitlines() if "will need" in line]
