"""`snakemake study` on a tiny scene: it trains its changes, and nothing that is there already."""

import pandas as pd
import pytest
import yaml
from support.tiny_workflow import CONFIG, planned, snakemake

from r3gw.files.strict import read_yaml

pytestmark = pytest.mark.slow

STUDY = CONFIG | {
    "study": {
        "baseline": "full",
        "seeds": [0],
        "changes": {"half_as_long": {"iterations": 20}, "opacity_0.3": {"init": {"opacity": 0.3}}},
    }
}


def test_a_study_compares_its_changes_with_runs_that_are_there(finished):
    trained = finished / "results/tiny/full/seed0/model.safetensors"
    before = trained.stat().st_mtime_ns
    done = snakemake(finished, "study", config=STUDY)
    assert done.returncode == 0, done.stderr
    assert trained.stat().st_mtime_ns == before
    table = pd.read_csv(finished / "results/study.csv").set_index("variant")
    assert list(table.index) == ["full", "half_as_long", "opacity_0.3"]
    assert list(table.change.fillna("")) == ["", "iterations 40 → 20", "init.opacity 0.1 → 0.3"]
    assert list(table.iterations) == [40, 20, 40]
    assert (table.training_seconds_mean > 0).all()
    full = pd.read_csv(finished / "results/table1.csv").iloc[0]
    assert table.loc["full", "psnr_exact_avg"] == full.psnr_exact_avg
    for name in ("study.md", "study_runs.csv", "figures/study.png", "figures/study.pdf"):
        assert (finished / "results" / name).stat().st_size > 0
    assert planned(finished, "study", STUDY) == set()


@pytest.mark.parametrize("name", ["short_runs", "chosen", "outline"])
def test_shipped_studies_keep_the_default_scenes(untouched, repository, name):
    shipped = read_yaml(repository / f"config/studies/{name}.yaml")
    assert set(shipped) - {"train"} == {"study"}
    done = snakemake(untouched, "--dry-run", "study", config=shipped)
    assert done.returncode == 0, done.stderr
    default = read_yaml(repository / "config/config.yaml")
    study = shipped["study"]
    trainings = len(default["scenes"]) * len(study["seeds"]) * (1 + len(study["changes"]))
    lines = (done.stdout + done.stderr).splitlines()
    assert ["train", str(trainings)] in [line.split() for line in lines]


def test_without_a_study_one_sentence_says_where_there_is_one(untouched):
    done = snakemake(untouched, "--dry-run", "study")
    assert done.returncode != 0
    assert "--configfile config/studies/short_runs.yaml" in done.stdout + done.stderr


def test_a_misspelt_setting_of_a_study_is_one_sentence(untouched):
    wrong = yaml.safe_load(yaml.safe_dump(STUDY))
    wrong["study"]["changes"]["opacity_0.3"] = {"init": {"opacitty": 0.3}}
    done = snakemake(untouched, "--dry-run", "all", config=wrong)
    assert done.returncode != 0
    text = done.stdout + done.stderr
    assert "variant 'opacity_0.3': unknown key 'init.opacitty'; did you mean 'opacity'?" in text
    assert "Traceback" not in text
