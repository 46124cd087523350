"""Folders of the user's, under any name: what is in them is read, and a change is seen."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from support import nerf_osr_layout
from support.tiny_workflow import CONFIG, checkout, planned, snakemake

pytestmark = pytest.mark.slow

# Blank, apostrophe, quotes, variable, wildcards and substitutions of a shell, a non-ASCII letter.
SHELL = 'it\'s "$HOME" *? (1) $(touch oops) `x`; & é #'
ODD = f"{SHELL} {{scene}} {{0}} {{"  # braces of formats and of wildcards

TARGET = "results/mine/checked.json"


def entry_of(place: Path, labels: Path):
    return {
        "format": "nerf-osr",
        "path": str(place),
        "sky_masks": "given",
        "label_maps": str(labels),
    }


@pytest.fixture(scope="module")
def odd(repository, tmp_path_factory):
    """A checkout and a scene in folders of an odd name, imported and checked."""
    base = tmp_path_factory.mktemp("odd")
    folder = checkout(repository, base / SHELL)
    place = nerf_osr_layout.build(base / "data" / ODD)
    labels = base / "labels"
    labels.mkdir()
    (labels / "unused.png").write_bytes(b"no photo has this name")
    config = CONFIG | {"scenes": {"mine": entry_of(place.folder, labels)}}
    done = snakemake(folder, TARGET, config=config)
    logs = "".join(path.read_text() for path in (folder / "logs").rglob("*.log"))
    assert done.returncode == 0, done.stdout + done.stderr + logs
    return folder, place, labels, config


def test_odd_names_reach_the_stages_as_they_are(odd):
    folder, _, _, config = odd
    assert (folder / TARGET).is_file()
    assert planned(folder, TARGET, config) == set()
    assert not list(folder.parent.rglob("oops"))


def touched(path: Path):
    status = path.stat()
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns + 1_000_000))


@pytest.mark.parametrize(
    ("which", "reruns", "keeps"),
    [
        ("photo", {"import_scene", "masks", "doctor_scene"}, set()),
        ("mask", {"import_scene", "masks", "doctor_scene"}, set()),
        ("model", {"import_scene", "initialise", "doctor_scene"}, set()),
        ("labels", {"masks", "doctor_scene"}, {"import_scene", "initialise"}),
    ],
)
def test_a_replaced_file_is_read_again(odd, which, reruns, keeps):
    folder, place, labels, config = odd
    path = {
        "photo": next((place.undistorted / "images").iterdir()),
        "mask": next((place.undistorted / "masks").iterdir()),
        "model": place.undistorted / "sparse/0/points3D.bin",
        "labels": labels / "unused.png",
    }[which]
    status = path.stat()
    touched(path)
    try:
        rules = planned(folder, TARGET, config)
    finally:
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert reruns <= rules
    assert not keeps & rules
    assert planned(folder, TARGET, config) == set()


def test_without_home_and_with_the_plainest_language(odd):
    """As a job of a cluster or of another user starts: no HOME, LANG=C."""
    folder, _, _, config = odd
    (folder / "mine.yaml").write_text(yaml.safe_dump(config))
    environment = {
        "PATH": os.environ["PATH"],
        "PYTHONPATH": str(folder / "src"),
        "LANG": "C",
        "LC_ALL": "C",
        "XDG_CACHE_HOME": str(folder / "cache"),
    }
    line = [sys.executable, "-m", "snakemake", "--cores", "1", "--forcerun", "masks", "--"]
    done = subprocess.run(
        [*line[:-1], "--configfile", "mine.yaml", "--", "results/mine/masks/masks.json"],
        capture_output=True, text=True, check=False, cwd=folder, env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "rule masks:" in done.stdout + done.stderr


def test_a_variant_with_an_odd_name_is_one_sentence(odd):
    folder, _, _, config = odd
    done = snakemake(folder, "--dry-run", "all", config=config | {"variants": ["my $(variant)"]})
    assert done.returncode != 0
    assert "key 'variants.0' has the value 'my $(variant)'" in done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr


def test_braces_in_the_checkouts_own_path_are_one_sentence(repository, tmp_path):
    folder = checkout(repository, tmp_path / "{scene}")
    done = snakemake(folder, "--dry-run", "all")
    assert done.returncode != 0
    text = done.stdout + done.stderr
    assert "Snakemake cannot run in a folder with a brace in its path; rename it" in text
    assert "Traceback" not in text
