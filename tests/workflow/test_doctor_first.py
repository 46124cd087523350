"""The doctor is the first rule of `all`, and what it refuses does not start."""

import pytest
from support.tiny_workflow import CONFIG, snakemake, started

pytestmark = pytest.mark.slow


def test_doctor_looked_before_the_training(finished):
    page = (finished / "results/doctor/doctor.md").read_text()
    assert "Nothing stands in the way of a run." in page
    assert (finished / "results/doctor/tiny_up.png").is_file()
    assert (finished / "results/figures/tiny_masks.png").is_file()
    scene = finished / "results/tiny"
    run = scene / "full/seed0"
    made = [scene / "checked_source.json", scene / "scene/scene.json", scene / "checked.json"]
    made += [run / "checked.json", run / "model.safetensors"]
    times = [path.stat().st_mtime_ns for path in made]
    assert times == sorted(times)


def test_doctor_comes_first(finished):
    rules = [rule for rule, _ in started((finished / "all.log").read_text())]
    assert rules[0] == "doctor_source"
    gates = [rules.index(name) for name in ("doctor_source", "doctor_scene", "doctor_run")]
    assert gates == sorted(gates)
    assert rules.index("doctor_source") < rules.index("generate")
    assert rules.index("doctor_run") < rules.index("train")


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
    assert "tiny/no_specular/seed0: a training will need about 70000.4 GB" in done.stderr
    assert "lower 'max_image_px' or 'density.max_gaussians'" in done.stderr
    assert [rule for rule, _ in started(done.stderr)] == ["write_settings", "doctor_run"]
