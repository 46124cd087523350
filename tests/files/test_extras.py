"""What is said when a library is not there."""

import subprocess
import sys

import pytest

from r3gw.files.extras import missing_system_library

SENTENCE = "libatomic.so.1: this library of the operating system is not installed; install it"


def raised(wake):
    """The error of a Python library whose system library is missing, met in the wake of it."""
    try:
        try:
            raise ImportError(
                "libatomic.so.1: cannot open shared object file: No such file or directory"
            )
        except ImportError:
            if wake is None:
                raise
            raise wake  # noqa: B904
    except (ImportError, NameError) as error:
        return error


@pytest.mark.parametrize("wake", [None, NameError("name '_drjit_ext' is not defined")])
def test_a_missing_library_of_the_system_is_named(wake):
    assert str(missing_system_library(raised(wake))).startswith(SENTENCE)


def test_other_errors_are_none_of_it():
    assert missing_system_library(ImportError("cannot import name 'chapel'")) is None
    assert missing_system_library(NameError("name 'chapel' is not defined")) is None
    assert missing_system_library(FileNotFoundError("cannot open shared object file")) is None


def test_a_command_that_needs_it_ends_in_that_sentence(tmp_path):
    broken = "raise ImportError('libatomic.so.1: cannot open shared object file: No such file')"
    (tmp_path / "drjit.py").write_text(
        f"try:\n    {broken}\nexcept ImportError:\n    _drjit_ext.__file__\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(folder=str(tmp_path))], capture_output=True, text=True
    )
    assert run.returncode == 2
    assert run.stderr.startswith(f"r3gw: {SENTENCE}")
    assert "Traceback" not in run.stderr


PROGRAM = """
import sys
sys.path.insert(0, {folder!r})
sys.argv = ["r3gw", "generate", "--settings", "{{}}", "--target", "nothing"]
from r3gw.__main__ import main
main()
"""
