"""The command line: help for every stage, and bad input as one sentence with exit status 2."""

import json
import subprocess
import sys

import pytest
from click.testing import CliRunner

from r3gw.__main__ import cli

pytestmark = pytest.mark.slow

SETTINGS = json.dumps({"building": "chapel"})


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "r3gw", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("stage", sorted(cli.commands))
def test_every_stage_has_help(stage):
    shown = CliRunner().invoke(cli, [stage, "--help"])
    assert shown.exit_code == 0
    body = shown.output.split("Options:")
    assert len(body[0].strip().splitlines()) >= 3  # usage and what the stage does
    writes = "--target" in shown.output or "--output" in shown.output
    assert writes or stage == "view"  # which shows a run and writes nothing


def test_missing_scene_is_one_sentence(tmp_path):
    done = run(
        "masks", "--scene", str(tmp_path), "--sources", "{}", "--target", str(tmp_path / "m")
    )
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert str(tmp_path / "scene.json") in done.stderr


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ('{"building": "chapel"', "not readable as JSON"),
        ("[1]", "expected a JSON object"),
        (json.dumps({"building": "chapel", "sampels": 3}), "sampels"),
    ],
)
def test_wrong_settings_name_what_is_wrong(tmp_path, settings, said):
    done = run("generate", "--settings", settings, "--target", str(tmp_path / "t"))
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "t").exists()


def test_a_library_of_an_extra_that_is_not_installed_is_one_sentence(tmp_path):
    arguments = ["generate", "--settings", SETTINGS, "--target", str(tmp_path / "t")]
    program = "import sys; sys.modules['mitsuba'] = None; from r3gw.__main__ import main; main()"
    command = [sys.executable, "-c", program, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == (
        "r3gw: this needs the Python library mitsuba, which is not installed: "
        "pip install 'r3gw[view]'\n"
    )
