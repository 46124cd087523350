"""The command line: help for every stage, and bad input as one sentence with exit status 2."""

import json
import os
import shlex
import subprocess
import sys

import pytest
from click.testing import CliRunner

from r3gw.__main__ import cli
from r3gw.cli.overview import EXAMPLES

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
    assert writes or stage in {"view", "doctor-sources", "doctor-run"}  # they show or refuse


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


def test_the_overview_has_an_example_of_every_command_that_its_options_take():
    shown = CliRunner().invoke(cli, ["--help"])
    assert shown.exit_code == 0
    examples = {name: text for group in EXAMPLES.values() for name, text in group.items()}
    assert set(examples) == set(cli.commands)
    for name, text in examples.items():
        first, *arguments = shlex.split(text)
        assert first == name
        cli.commands[name].make_context(name, arguments)  # raises where an option is wrong
        assert f"r3gw {name}" in shown.output
    listed = shown.output.partition("Options:")[2]
    assert "..." not in listed  # nothing is too long for a terminal of 80 columns


@pytest.mark.parametrize(
    ("options", "is_shown"),
    [((), (True, False)), (("-q",), (False, False)), (("-v",), (True, True))],
)
def test_quiet_and_verbose(options, is_shown):
    program = (
        "import logging, sys; from r3gw.cli.group import cli\n"
        "@cli.command()\n"
        "def probe():\n"
        "    logging.getLogger('r3gw.probe').info('ours')\n"
        "    logging.getLogger('other').info('theirs')\n"
        "    from tqdm import tqdm\n"
        "    list(tqdm(range(3)))\n"
        "cli()"
    )
    command = [sys.executable, "-c", program, *options, "probe"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert ("ours" in done.stderr, "theirs" in done.stderr) == is_shown
    assert ("3/3" in done.stderr) == (options != ("-q",))


@pytest.mark.parametrize("command", [["--help"], ["relight", "--help"], ["train", "--help"]])
def test_help_imports_no_heavy_library(command):
    program = (
        f"import sys; sys.argv = ['r3gw', *{command!r}]\n"
        "from r3gw.__main__ import main\n"
        "try:\n    main()\n"
        "finally:\n    sys.stderr.write(str({'torch', 'numpy', 'pydantic'} & {*sys.modules}))"
    )
    line = [sys.executable, "-c", program]
    done = subprocess.run(line, capture_output=True, text=True, check=True)
    assert done.stderr == "set()"


def test_the_shell_completes_commands():
    program = "import sys; sys.argv = ['r3gw']; from r3gw.__main__ import main; main()"
    asked = {"_R3GW_COMPLETE": "bash_complete", "COMP_WORDS": "r3gw rel", "COMP_CWORD": "1"}
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True, text=True, check=True, env=os.environ | asked,
    )  # fmt: skip
    assert done.stdout.split() == ["plain,relight"]
