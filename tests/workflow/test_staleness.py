"""An edit makes again what depends on it, in the scene that it concerns, and nothing else."""

import pytest
from support.tiny_workflow import CONFIG, TWO, edited, planned, planned_jobs, scenes_of

pytestmark = pytest.mark.slow


def test_second_run_does_nothing(finished):
    assert planned(finished, "all") == set()


def test_edited_settings_retrain_but_do_not_render(finished):
    changed = CONFIG | {"train": CONFIG["train"] | {"iterations": 41}}
    rules = planned(finished, "all", changed)
    assert {"write_settings", "train", "evaluate", "table1"} <= rules
    assert not {"generate", "import_scene", "masks", "doctor_scene"} & rules


def test_added_scene_makes_no_other_again(with_twin):
    jobs = planned_jobs(with_twin, "all", TWO)
    assert scenes_of("train", jobs) == {"twin"}
    assert {rule for rule, scene in jobs if scene == "tiny"} == set()


def test_edited_scene_makes_no_other_again(with_twin):
    entry = TWO["scenes"]["twin"] | {"samples": 2}
    jobs = planned_jobs(with_twin, "all", TWO | {"scenes": TWO["scenes"] | {"twin": entry}})
    for rule in ("doctor_source", "generate", "import_scene", "doctor_scene", "train"):
        assert scenes_of(rule, jobs) == {"twin"}
    assert {rule for rule, scene in jobs if scene == "tiny"} == set()


def test_edited_scene_does_not_hide_edited_code(with_twin):
    entry = TWO["scenes"]["twin"] | {"samples": 2}
    with edited(with_twin / "src/r3gw/training/loop.py"):
        jobs = planned_jobs(with_twin, "all", TWO | {"scenes": TWO["scenes"] | {"twin": entry}})
    assert scenes_of("generate", jobs) == {"twin"}
    assert scenes_of("train", jobs) == {"tiny", "twin"}


@pytest.mark.parametrize(
    ("source", "reruns", "keeps"),
    [
        ("shading/cook_torrance.py", {"train", "evaluate"}, {"generate", "masks"}),
        ("raster/csrc/projection.cpp", {"train"}, {"generate"}),
        ("reporting/tables.py", {"table1"}, {"train", "evaluate"}),
        ("doctor/page.py", {"doctor"}, {"generate", "import_scene", "doctor_scene", "train"}),
        ("doctor/source.py", {"doctor"}, {"doctor_source", "generate", "import_scene", "train"}),
        ("doctor/training.py", {"doctor"}, {"doctor_scene", "doctor_run", "train", "evaluate"}),
        ("reporting/templates/report.css", {"html_report"}, {"train", "evaluate"}),
    ],
)
def test_edited_code_reruns_what_depends_on_it(finished, source, reruns, keeps):
    with edited(finished / "src/r3gw" / source):
        rules = planned(finished, "all")
    assert reruns <= rules
    assert not keeps & rules


def test_ablations_are_planned(finished):
    rules = planned(finished, "ablations")
    assert {"train", "evaluate", "ablation_table"} <= rules
    assert "generate" not in rules
