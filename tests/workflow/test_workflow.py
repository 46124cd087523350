"""The real workflow: a tiny run from rendering to the table, then nothing left to do."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import layout_a
import numpy as np
import pandas as pd
import pytest
from tiny_workflow import CONFIG, planned, snakemake

from r3gw.reporting.kinds import PICTURES, PLOTS
from r3gw.settings import load_config
from r3gw.settings.validation import read_yaml


@contextmanager
def edited(path: Path) -> Iterator[None]:
    """Append an empty line to a source file for a while."""
    before = path.read_text()
    path.write_text(before + "# edited\n")
    try:
        yield
    finally:
        path.write_text(before)


def test_table_holds_finite_figures(finished):
    table = pd.read_csv(finished / "results/table1.csv")
    assert len(table) == 1
    for metric in ("psnr", "ssim", "mse", "mae"):
        for place in ("tiny", "avg"):
            assert np.isfinite(table.loc[0, f"{metric}_{place}"])
    assert table.loc[0, "n_seeds"] == 1
    assert table.loc[0, "iterations"] == 40


def test_doctor_looked_before_the_training(finished):
    page = (finished / "results/doctor/doctor.md").read_text()
    assert "Nothing stands in the way of a run." in page
    assert (finished / "results/doctor/tiny_up.png").is_file()
    assert (finished / "results/figures/tiny_masks.png").is_file()
    scene = finished / "results/tiny"
    made = ("checked_source.json", "scene/scene.json", "checked.json", "full/seed0/model.pt")
    times = [(scene / name).stat().st_mtime_ns for name in made]
    assert times == sorted(times)


def test_cost_report_and_figures_come_with_all(finished):
    cost = pd.read_csv(finished / "results/cost.csv")
    assert cost.loc[0, "renders_per_second"] > 0
    images = pd.read_csv(finished / "results/images.csv")
    assert set(images.protocol) == {"nerf-osr", "full-yaw", "exact", "learned"}
    assert "Scene tiny" in (finished / "results/report.html").read_text()
    figures = {path.stem for path in (finished / "results/figures").glob("*.png")}
    assert {f"tiny_{kind}" for kind in (*PICTURES, *PLOTS)} <= figures


def test_snakemakes_own_report_shows_tables_and_figures(finished):
    done = snakemake(finished, "--report", "snakemake.html", "all")
    assert done.returncode == 0, done.stderr
    text = (finished / "snakemake.html").read_text()
    for piece in ("table1.csv", "tiny_sky_boundary.png", "Relightable 3D Gaussians outdoors"):
        assert piece in text


def test_second_run_does_nothing(finished):
    assert planned(finished, "all") == set()


def test_edited_settings_retrain_but_do_not_render(finished):
    changed = CONFIG | {"train": CONFIG["train"] | {"iterations": 41}}
    rules = planned(finished, "all", changed)
    assert {"write_settings", "train", "evaluate", "table1"} <= rules
    assert not {"generate", "import_scene", "masks", "check_scene"} & rules


@pytest.mark.parametrize(
    ("source", "reruns", "keeps"),
    [
        ("shading/cook_torrance.py", {"train", "evaluate"}, {"generate", "masks"}),
        ("raster/csrc/projection.cpp", {"train"}, {"generate"}),
        ("reporting/tables.py", {"table1"}, {"train", "evaluate"}),
        ("doctor/page.py", {"doctor"}, {"generate", "import_scene", "check_scene", "train"}),
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


def test_misspelt_config_key_is_one_sentence(untouched):
    wrong = dict(CONFIG)
    wrong["varients"] = wrong.pop("variants")
    done = snakemake(untouched, "--dry-run", "all", config=wrong)
    assert done.returncode != 0
    text = done.stdout + done.stderr
    assert "unknown key 'varients'; did you mean 'variants'?" in text
    assert "Traceback" not in text


def test_missing_photo_folder_is_one_sentence(untouched):
    wrong = CONFIG | {"scenes": {"mine": {"format": "photos", "path": "nowhere"}}}
    done = snakemake(untouched, "--dry-run", "all", config=wrong)
    assert done.returncode != 0
    sentence = "nowhere: no such file or folder; correct 'path' of scene 'mine'"
    assert sentence in done.stdout + done.stderr


def test_incomplete_dataset_is_named_before_anything_runs(untouched):
    place = layout_a.build(untouched / "place")
    entry = {"format": "nerf-osr", "path": "place"}
    config = CONFIG | {"scenes": {"mine": entry}}
    assert snakemake(untouched, "--dry-run", "all", config=config).returncode == 0
    (place.undistorted / "images" / f"{layout_a.STEMS[0]}.jpg").unlink()
    done = snakemake(untouched, "--dry-run", "all", config=config)
    assert done.returncode != 0
    text = done.stdout + done.stderr
    assert f"one file is missing for scene 'mine' (undistorted/images/{layout_a.STEMS[0]}" in text
    assert "Traceback" not in text


@pytest.mark.parametrize("name", ["config", "photos", "nerf_osr"])
def test_shipped_configs_are_valid(repository, name):
    assert load_config(read_yaml(repository / f"config/{name}.yaml")).scenes
