"""The workflow where other people find it: the catalogue's layout, and as a module of another."""

import shutil
import subprocess
import sys

import pytest
import yaml
from support.tiny_workflow import CONFIG, checkout, started

pytestmark = pytest.mark.slow


def planned(folder, *arguments):
    """Rules and scenes of the jobs that Snakemake would run in a folder."""
    command = [sys.executable, "-m", "snakemake", "--cores", "2", "--dry-run", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return set(started(done.stdout + done.stderr))


def test_the_layout_is_the_catalogue_s(repository):
    for name in ("workflow/Snakefile", "config/README.md", ".test/config/config.yaml", "LICENSE"):
        assert (repository / name).is_file()
    usage = yaml.safe_load((repository / ".snakemake-workflow-catalog.yml").read_text())["usage"]
    assert set(usage) <= {"mandatory-flags", "software-stack-deployment", "report"}
    assert usage["software-stack-deployment"] == {"conda": False, "apptainer": True}
    assert usage["report"] is True


def test_the_root_s_snakefile_makes_what_the_workflow_s_does(repository, tmp_path):
    folder = checkout(repository, tmp_path)
    jobs = planned(folder)
    assert planned(folder, "all") == planned(folder, "--snakefile", "workflow/Snakefile")
    assert {rule for rule, _ in jobs} - {"default"} == {
        *("generate", "import_scene", "masks", "initialise", "doctor", "doctor_scene"),
        *("mask_sheet", "write_settings", "train", "evaluate", "table1", "figures", "page"),
        "html_report",
    }


def test_the_catalogue_s_test_runs_in_its_own_folder(repository, tmp_path):
    shutil.copytree(repository / ".test", tmp_path / ".test")
    snakefile = repository / "workflow/Snakefile"
    jobs = planned(tmp_path, "--snakefile", str(snakefile), "--directory", ".test")
    assert ("import_scene", "tiny") in jobs


OTHER = """
configfile: "config.yaml"

module r3gw:
    snakefile: {snakefile!r}
    config: config["r3gw"]

use rule * from r3gw as r3gw_*

rule film:
    default_target: True
    input:
        model="results/tiny/full/seed0/model.safetensors",
        scene="results/tiny/scene/scene.json",
    output:
        "film.mp4",
    shell:
        "r3gw relight --model {{input.model}} --scene results/tiny/scene --output {{output}}"
"""


def test_another_workflow_uses_it_as_a_module(repository, tmp_path):
    snakefile = str(repository / "workflow/Snakefile")
    (tmp_path / "Snakefile").write_text(OTHER.format(snakefile=snakefile))
    (tmp_path / "config.yaml").write_text(yaml.safe_dump({"r3gw": CONFIG}))
    rules = {rule for rule, _ in planned(tmp_path)}
    assert rules == {
        "film", "r3gw_generate", "r3gw_import_scene", "r3gw_masks", "r3gw_initialise",
        "r3gw_doctor_scene", "r3gw_write_settings", "r3gw_train",
    }  # fmt: skip
