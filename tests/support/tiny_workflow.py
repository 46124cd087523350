"""Runs the real workflow on tiny scenes, in a copy that tests may edit."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml

Jobs = set[tuple[str, str | None]]  # rule and scene

CONFIG: dict[str, Any] = {
    "scenes": {
        "tiny": {
            "format": "synthetic",
            "building": "chapel",
            "width_px": 64,
            "height_px": 48,
            "train_views": 6,
            "test_views": 2,
            "samples": 1,
        }
    },
    "variants": ["full"],
    "seeds": [0],
    "ablations": {"variants": ["no_specular"], "seeds": [0]},
    "train": {
        "iterations": 40,
        "density": {"max_gaussians": 6000},
        "sky": {"min_count": 100, "max_count": 200},
    },
}


# A second scene, for what must not pass from one to the other.
TWO = CONFIG | {"scenes": CONFIG["scenes"] | {"twin": CONFIG["scenes"]["tiny"] | {"seed": 1}}}


def checkout(repository: Path, folder: Path) -> Path:
    """Copy what the workflow is made of, the package too, so that tests may edit it."""
    for name in ("workflow", "config", "src", "profiles"):
        without = shutil.ignore_patterns("*.so", "__pycache__", "*.egg-info")
        shutil.copytree(repository / name, folder / name, ignore=without)
    shutil.copy(repository / "Snakefile", folder)
    for extension in (repository / "src/r3gw").glob("_C*.so"):
        (folder / "src/r3gw" / extension.name).symlink_to(extension)
    return folder


def snakemake(
    folder: Path, *arguments: str, config: dict[str, Any] = CONFIG
) -> subprocess.CompletedProcess[str]:
    """Run the workflow of the copy in ``folder``."""
    (folder / "mine.yaml").write_text(yaml.safe_dump(config))
    command = [sys.executable, "-m", "snakemake", "--cores", "2", "--configfile", "mine.yaml"]
    environment = os.environ | {
        "XDG_CACHE_HOME": str(folder / "cache"),
        "PYTHONPATH": str(folder / "src"),
    }
    return subprocess.run(
        [*command[:3], *arguments, *command[3:]],
        capture_output=True, text=True, check=False, env=environment, cwd=folder,
    )  # fmt: skip


def started(log: str) -> list[tuple[str, str | None]]:
    """Rule and scene of every job, in the order in which a log names them."""
    jobs: list[tuple[str, str | None]] = []
    for line in log.splitlines():
        if found := re.match(r"(?:local)?rule (\w+):", line):
            jobs.append((found[1], None))
        elif found := re.match(r" +wildcards:.*scene=(\w+)", line):
            jobs[-1] = (jobs[-1][0], found[1])
    return jobs


def planned_jobs(folder: Path, target: str, config: dict[str, Any] = CONFIG) -> Jobs:
    """Rules that a dry run would execute, with their scenes."""
    done = snakemake(folder, "--dry-run", target, config=config)
    assert done.returncode == 0, done.stderr
    return set(started(done.stdout + done.stderr))


def planned(folder: Path, target: str, config: dict[str, Any] = CONFIG) -> set[str]:
    """Names of the rules that a dry run would execute."""
    return {rule for rule, _ in planned_jobs(folder, target, config)}


def scenes_of(rule: str, jobs: Jobs) -> set[str | None]:
    """Scenes for which jobs hold a rule."""
    return {scene for name, scene in jobs if name == rule}
