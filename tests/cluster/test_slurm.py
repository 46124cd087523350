"""The workflow on a real Slurm: end to end, a node that dies, too little memory.

`make cluster-test`; no part of the usual run, since it needs root and Debian's Slurm.
"""

import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml
from cluster.slurm import Cluster
from support.tiny_workflow import CONFIG, snakemake

VARIANTS = ["full", "r3gw_plus"]
SMALL = CONFIG | {"variants": VARIANTS, "train": CONFIG["train"] | {"iterations": 150}}
LONG = SMALL | {"train": CONFIG["train"] | {"iterations": 3000}}
MODEL = "results/tiny/full/seed0/model.safetensors"
MEASURED = {"timing.json", "cost.json", "cost.csv", "report.html"}


def start(cluster: Cluster, folder: Path, *arguments: str, config: dict) -> subprocess.Popen[str]:
    """Start the workflow with the profile for Slurm; asked more often than a real cluster is."""
    (folder / "mine.yaml").write_text(yaml.safe_dump(config))
    line = [sys.executable, "-m", "snakemake", *arguments, "--profile", "profiles/slurm"]
    line += ["--configfile", "mine.yaml", "--latency-wait", "10", "--slurm-no-account"]
    # This Slurm keeps no books that sacct could read.
    line += ["--slurm-init-seconds-before-status-checks", "3", "--slurm-status-command", "squeue"]
    environment = cluster.environment | {
        "PYTHONPATH": str(folder / "src"),
        "XDG_CACHE_HOME": str(folder / "cache"),
        "R3GW_CHECKPOINT_SECONDS": "1",
        "OMP_NUM_THREADS": "1",
    }
    with (folder / "run.log").open("w") as log:
        return subprocess.Popen(
            line, cwd=folder, env=environment, text=True, stdout=subprocess.DEVNULL, stderr=log
        )


def running(cluster: Cluster) -> dict[str, str]:
    """The jobs that run: what each is, and its node."""
    lines = cluster.call("squeue", "-h", "--states=running", "-o", "%k|%N").splitlines()
    return dict(line.rsplit("|", 1) for line in lines)


def contents(folder: Path) -> dict[str, bytes]:
    """Every result that nothing was measured for, by name."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in (folder / "results").rglob("*")
        if path.is_file() and path.name not in MEASURED and not path.name.startswith(".")
    }


@pytest.fixture(scope="module")
def finished(cluster, checked_out) -> tuple[Path, int]:
    """The copy in which `all` has run on the cluster, and how many trainings ran at once."""
    run = start(cluster, checked_out, "all", config=SMALL)
    most = 0
    while run.poll() is None:
        most = max(most, sum(name.startswith("rule_train") for name in running(cluster)))
        time.sleep(0.5)
    assert run.returncode == 0, (checked_out / "run.log").read_text()
    return checked_out, most


def test_two_trainings_run_at_once_and_small_jobs_as_one(finished):
    folder, most = finished
    assert most == 2
    log = (folder / "run.log").read_text()
    assert len(re.findall(r"has been submitted with SLURM jobid", log)) == 13
    assert len(re.findall(r"Job [0-9a-f-]{36} has been submitted", log)) == 1  # a group


def test_the_bytes_are_those_of_a_run_on_this_machine(finished, tmp_path):
    folder, _ = finished
    here = Path(shutil.copytree(folder, tmp_path / "here", symlinks=True))
    shutil.rmtree(here / "results")
    done = snakemake(here, "all", config=SMALL)
    assert done.returncode == 0, done.stderr
    expected, found = contents(here), contents(folder)
    assert set(found) == set(expected)
    assert [name for name in found if found[name] != expected[name]] == []


def test_a_training_goes_on_elsewhere_when_its_node_dies(cluster, finished, tmp_path):
    folder = Path(shutil.copytree(finished[0], tmp_path / "node", symlinks=True))
    log = folder / "logs/train/tiny.full.seed0.log"
    run = start(cluster, folder, MODEL, config=LONG)
    while not list((folder / MODEL).parent.glob(".checkpoint-*")):
        assert run.poll() is None, (folder / "run.log").read_text()
        time.sleep(0.2)
    ((training, node),) = running(cluster).items()
    assert training.startswith("rule_train")
    cluster.kill_node(node)
    assert run.wait() == 0, (folder / "run.log").read_text()
    assert re.search(r"continuing from \S+ at iteration [1-9]", log.read_text())
    assert "Trying to restart job" in (folder / "run.log").read_text()
    disturbed = (folder / MODEL).read_bytes()
    cluster.start_node(node)
    cluster.wait_for_nodes()
    (folder / MODEL).unlink()
    done = snakemake(folder, MODEL, config=LONG)
    assert done.returncode == 0, done.stderr
    assert (folder / MODEL).read_bytes() == disturbed


def test_too_little_memory_is_said_and_the_next_attempt_asks_for_more(cluster, finished, tmp_path):
    folder = Path(shutil.copytree(finished[0], tmp_path / "memory", symlinks=True))
    (folder / MODEL).unlink()
    too_little = ("--set-resources", "train:mem_mb=250 if attempt == 1 else 1500")
    run = start(cluster, folder, MODEL, *too_little, config=SMALL)
    assert run.wait() == 0, (folder / "run.log").read_text()
    said = (folder / "run.log").read_text()
    assert (
        "r3gw: train (scene=tiny, variant=full, seed=0) needed more than the 250 MB of memory "
        "that it had asked for; Slurm ended it" in said
    )
    assert (folder / MODEL).read_bytes() == (finished[0] / MODEL).read_bytes()


def test_one_scene_on_the_disk_of_a_node(cluster, finished, tmp_path):
    """Nothing is shared but the folder that results come home to; nothing is made twice."""
    home, log = tmp_path / "home", tmp_path / "job.log"
    home.mkdir()
    (home / "mine.yaml").write_text(yaml.safe_dump(SMALL))
    script = finished[0] / "profiles/one_scene.sh"
    environment = {
        "PATH": f"{Path(sys.executable).parent}:{cluster.environment['PATH']}",
        "PYTHONPATH": str(finished[0] / "src"),
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        "R3GW_SCRATCH": str(tmp_path / "scratch"),
    }
    wrapped = f"bash {script} {home} {home}/mine.yaml tiny full 0 --cores 2"
    job = ("sbatch", "--wait", "--cpus-per-task=2", "--output", str(log), "--wrap", wrapped)
    cluster.call(*job, more=environment)
    assert (home / MODEL).read_bytes() == (finished[0] / MODEL).read_bytes()
    shutil.rmtree(tmp_path / "scratch")
    log.unlink()
    cluster.call(*job, more=environment)
    assert "Nothing to be done" in log.read_text()
