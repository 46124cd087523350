"""The real workflow: a tiny run from rendering to the table, and what it refuses to begin."""

import numpy as np
import pandas as pd
import pytest
from support import nerf_osr_layout
from support.tiny_workflow import CONFIG, snakemake

from r3gw.files.strict import read_yaml
from r3gw.pipeline.config import load_config
from r3gw.reporting.figures.kinds import PICTURES, PLOTS

pytestmark = pytest.mark.slow


def test_table_holds_finite_figures(finished):
    table = pd.read_csv(finished / "results/table1.csv")
    assert len(table) == 1
    for metric in ("psnr", "ssim", "mse", "mae"):
        for place in ("tiny", "avg"):
            assert np.isfinite(table.loc[0, f"{metric}_{place}"])
    assert table.loc[0, "n_seeds"] == 1
    assert table.loc[0, "iterations"] == 40


def test_cost_report_and_figures_come_with_all(finished):
    cost = pd.read_csv(finished / "results/cost.csv")
    assert cost.loc[0, "renders_per_second"] > 0
    images = pd.read_csv(finished / "results/images.csv")
    assert set(images.protocol) == {
        "nerf-osr",
        "full-yaw",
        "nerf-osr-linear",
        "exact",
        "half-image",
        "learned",
    }
    assert "Scene tiny" in (finished / "results/report.html").read_text()
    figures = {path.stem for path in (finished / "results/figures").glob("*.png")}
    assert {f"tiny_{kind}" for kind in (*PICTURES, *PLOTS)} <= figures


def test_snakemakes_own_report_shows_tables_and_figures(finished):
    done = snakemake(finished, "--report", "snakemake.html", "all")
    assert done.returncode == 0, done.stderr
    text = (finished / "snakemake.html").read_text()
    for piece in ("table1.csv", "tiny_sky_boundary.png", "Relightable 3D Gaussians outdoors"):
        assert piece in text


def test_misspelt_config_key_is_one_sentence(untouched):
    wrong = dict(CONFIG)
    wrong["varients"] = wrong.pop("variants")
    done = snakemake(untouched, "--dry-run", "all", config=wrong)
    assert done.returncode != 0
    text = done.stdout + done.stderr
    assert "unknown key 'varients'; did you mean 'variants'?" in text
    assert "Traceback" not in text


def test_every_missing_photo_folder_is_one_sentence(untouched):
    scenes = {name: {"format": "photos", "path": "nowhere"} for name in ("mine", "yours")}
    done = snakemake(untouched, "--dry-run", "all", config=CONFIG | {"scenes": scenes})
    assert done.returncode != 0
    for name in scenes:
        sentence = f"nowhere: no such file or folder; correct 'path' of scene '{name}'"
        assert sentence in done.stdout + done.stderr


def test_incomplete_dataset_is_named_before_anything_runs(untouched):
    place = nerf_osr_layout.build(untouched / "place")
    entry = {"format": "nerf-osr", "path": "place"}
    config = CONFIG | {"scenes": {"mine": entry}}
    assert snakemake(untouched, "--dry-run", "all", config=config).returncode == 0
    (place.undistorted / "images" / f"{nerf_osr_layout.STEMS[0]}.jpg").unlink()
    done = snakemake(untouched, "--dry-run", "all", config=config)
    assert done.returncode != 0
    text = done.stdout + done.stderr
    assert (
        f"one file is missing for scene 'mine' (undistorted/images/{nerf_osr_layout.STEMS[0]}"
        in text
    )
    assert "Traceback" not in text


@pytest.mark.parametrize("name", ["config", "photos", "nerf_osr"])
def test_shipped_configs_are_valid(repository, name):
    assert load_config(read_yaml(repository / f"config/{name}.yaml")).scenes
