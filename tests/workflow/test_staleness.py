"""An edit makes again what depends on it, in the scene that it concerns, and nothing else."""

import pytest
from support.package_copy import edited
from support.tiny_workflow import CONFIG, TWO, planned, planned_jobs, scenes_of, snakemake

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
    for rule in ("generate", "import_scene", "doctor_scene", "train"):
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
        # What a job makes again goes on from there; tests/pipeline/test_code.py has every stage.
        ("rendering/compose.py", {"train", "evaluate"}, {"generate", "import_scene", "masks"}),
        ("masks/classical.py", {"masks", "train"}, {"generate", "import_scene", "initialise"}),
        ("reporting/tables/table1.py", {"table1"}, {"train", "evaluate"}),
        ("pipeline/doctor/page.py", {"doctor"}, {"generate", "doctor_scene", "train"}),
        ("pipeline/doctor/source.py", {"doctor"}, {"generate", "import_scene", "train"}),
        ("reporting/page/templates/report.css", {"html_report"}, {"train", "evaluate"}),
        ("relight/files/gltf.py", set(), {"train", "evaluate", "table1", "figures"}),
    ],
)
def test_edited_code_reruns_what_depends_on_it(finished, source, reruns, keeps):
    with edited(finished / "src/r3gw" / source):
        rules = planned(finished, "all")
    assert reruns <= rules
    assert not keeps & rules


def test_edited_mask_settings_do_not_import_again(finished):
    entry = CONFIG["scenes"]["tiny"] | {"sky_masks": "given-or-classical"}
    rules = planned(finished, "all", CONFIG | {"scenes": {"tiny": entry}})
    assert {"masks", "train", "evaluate"} <= rules
    assert not {"generate", "import_scene", "initialise"} & rules


def test_edited_import_settings_do_not_render_again(finished):
    entry = CONFIG["scenes"]["tiny"] | {"extent": 5.0}
    rules = planned(finished, "all", CONFIG | {"scenes": {"tiny": entry}})
    assert {"import_scene", "masks", "initialise", "train"} <= rules
    assert "generate" not in rules


def test_an_edited_kernel_stops_the_workflow_until_it_is_built(finished):
    with edited(finished / "src/r3gw/raster/csrc/projection.cpp"):
        done = snakemake(finished, "all")
    assert done.returncode != 0
    text = done.stdout + done.stderr
    assert "was built from other sources than those beside it" in text
    assert "build it again: `make`" in text
    assert "Traceback" not in text
    assert planned(finished, "all") == set()


def test_ablations_are_planned(finished):
    rules = planned(finished, "ablations")
    assert {"train", "evaluate", "ablation_table"} <= rules
    assert "generate" not in rules
