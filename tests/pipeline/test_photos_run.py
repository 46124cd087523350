"""r3gw photos: settings of its own, the workflow underneath, and what to look at in the end."""

import os
import signal
import subprocess
import sys

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from support.made_up_runs import make_run

from r3gw.__main__ import cli
from r3gw.files import InputError
from r3gw.files.strict import read_yaml
from r3gw.pipeline import photos_run
from r3gw.pipeline.photos_run import prepare, repository, run_workflow, to_look_at


@pytest.fixture
def folder(tmp_path):
    """A folder of three pictures whose name YAML and shells would misread."""
    folder = tmp_path / "my: holiday's"
    folder.mkdir()
    for number in range(3):
        noise = np.random.default_rng(number).integers(0, 255, (40, 60, 3), np.uint8)
        cv2.imwrite(str(folder / f"{number}.png"), noise)
    return folder


def prepared(folder, tmp_path):
    return prepare(folder, tmp_path / "out", repository() / "config" / "photos.yaml")


def test_settings_are_those_of_the_repository_for_this_folder(folder, tmp_path):
    values = read_yaml(prepared(folder, tmp_path))
    expected = read_yaml(repository() / "config" / "photos.yaml")
    expected["scenes"]["mine"]["path"] = str(folder)
    assert values == expected


def test_edited_settings_are_kept(folder, tmp_path):
    path = prepared(folder, tmp_path)
    edited = path.read_text().replace("iterations: 3000", "iterations: 7")
    path.write_text(edited)
    assert prepared(folder, tmp_path).read_text() == edited


def test_results_of_other_photos_are_not_overwritten(folder, tmp_path):
    prepared(folder, tmp_path)
    other = tmp_path / "other"
    other.mkdir()
    with pytest.raises(InputError, match=r"is of other photos.*name another --target"):
        prepared(other, tmp_path)


def test_a_folder_that_is_not_there_writes_nothing(tmp_path):
    done = CliRunner().invoke(cli, ["photos", str(tmp_path / "x"), "--target", str(tmp_path / "t")])
    assert isinstance(done.exception, InputError)
    assert "name one that holds your photos" in str(done.exception)
    assert not (tmp_path / "t").exists()


def test_what_there_is_to_look_at_exists_and_is_three_lights(folder, tmp_path):
    path = prepared(folder, tmp_path)
    variant = read_yaml(path)["variants"][0]
    make_run(path.parent / "results" / "mine" / variant / "seed0", variant, with_test=False)
    found = to_look_at(path)
    assert [name for name, _ in found[:2]] == ["report", "to relight in a browser"]
    assert [name for name, _ in found[2:]] == ["t in the light of t"]  # it has one photo
    assert all(picture.is_file() for _, picture in found[2:])


def test_a_workflow_that_stops_says_how_to_go_on(folder, tmp_path, monkeypatch):
    path = prepared(folder, tmp_path)
    calls = []
    monkeypatch.setattr(photos_run, "exit_status", lambda command: calls.append(command) or 1)
    with pytest.raises(InputError, match="the same command goes on from there"):
        run_workflow(path, 3, ["--keep-going"])
    assert calls[0][0] == sys.executable
    assert calls[0][-4:] == ["--cores", "3", "--keep-going", "all"]


# Written past sys.stdout: the signal may come while "begun" is still being printed.
TIDY = """
import os, signal, sys, time
def tidy_up(*_):
    time.sleep(0.8)
    os.write(1, b"tidy\\n")
    sys.exit(7)
signal.signal(signal.SIGINT, tidy_up)
os.write(1, b"begun\\n")
time.sleep(60)
"""
RUN = f"""
import sys
from r3gw.pipeline.photos_run import exit_status
print("status", exit_status([sys.executable, "-c", {TIDY!r}]), flush=True)
"""


@pytest.mark.slow
def test_an_interrupted_workflow_may_end_its_jobs():
    """Both processes get the signal, as from a terminal; it takes longer than Python would wait."""
    command = [sys.executable, "-c", RUN]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as running:
        assert running.stdout.readline() == "begun\n"
        os.killpg(running.pid, signal.SIGINT)
        assert running.stdout.read().splitlines() == ["tidy", "status 7"]


@pytest.mark.slow
def test_the_workflow_plans_everything_up_to_the_report(folder, tmp_path):
    target = tmp_path / "out"
    command = [sys.executable, "-m", "r3gw", "photos", str(folder), "--target", str(target)]
    done = subprocess.run([*command, "--dry-run"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for rule in ("import_scene", "masks", "train", "evaluate", "html_report"):
        assert f"rule {rule}:" in done.stdout + done.stderr, rule
    assert not (target / "results").exists()
