"""A copy of the workflow that tests may edit, and a configuration small enough to run it with."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml

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


def checkout(repository: Path, folder: Path) -> Path:
    """Copy what the workflow is made of, so that tests may edit it."""
    for name in ("workflow", "config", "src"):
        without = shutil.ignore_patterns("*.so", "__pycache__", "*.egg-info")
        shutil.copytree(repository / name, folder / name, ignore=without)
    shutil.copy(repository / "Snakefile", folder)
    return folder


def snakemake(
    folder: Path, *arguments: str, config: dict[str, Any] = CONFIG
) -> subprocess.CompletedProcess[str]:
    """Run the workflow of the copy in ``folder``."""
    (folder / "mine.yaml").write_text(yaml.safe_dump(config))
    command = [sys.executable, "-m", "snakemake", "--cores", "2", "--configfile", "mine.yaml"]
    environment = os.environ | {"XDG_CACHE_HOME": str(folder / "cache")}
    return subprocess.run(
        [*command[:3], *arguments, *command[3:]],
        capture_output=True, text=True, check=False, env=environment, cwd=folder,
    )  # fmt: skip


def planned(folder: Path, target: str, config: dict[str, Any] = CONFIG) -> set[str]:
    """Names of the rules that a dry run would execute."""
    done = snakemake(folder, "--dry-run", target, config=config)
    assert done.returncode == 0, done.stderr
    lines = (done.stdout + done.stderr).splitlines()
    rules = (line.split() for line in lines if line.startswith(("rule ", "localrule ")))
    return {words[1].rstrip(":") for words in rules}
