"""The command group, and the kinds of option that its commands share."""

import json
import logging
import os
import sys
from pathlib import Path
from typing import Any

import click

from r3gw.cli.overview import OverviewGroup
from r3gw.files import InputError

FOLDER = click.Path(file_okay=False, path_type=Path)
FILE = click.Path(dir_okay=False, path_type=Path)
THREADS = click.option("--threads", type=click.IntRange(1), default=1, help="CPU threads.")


@click.group(cls=OverviewGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="r3gw")
@click.option("--quiet", "-q", "level", flag_value=logging.ERROR, type=int, help="Errors alone.")
@click.option(
    "--verbose", "-v", "level", flag_value=logging.DEBUG, type=int, help="Libraries' messages too."
)
def cli(level: int | None) -> None:
    """Relightable 3D Gaussians for outdoor scenes in the wild.

    `r3gw photos FOLDER` makes a scene of your photos; `make all`, in a clone, the embedded scenes.
    `r3gw COMMAND --help` says more of each command.

    \b
    Exit status:
      0  done
      1  the doctor found problems; Ctrl-C; or a fault of r3gw itself (with a traceback)
      2  a file, an option or a value will not do (in one sentence)
    """
    # Libraries only warn: fontTools alone writes hundreds of INFO lines per figure.
    everyone = level if level in (logging.DEBUG, logging.ERROR) else logging.WARNING
    logging.basicConfig(level=everyone, format="%(message)s", stream=sys.stderr)
    logging.getLogger("r3gw").setLevel(level or logging.INFO)
    if level == logging.ERROR:
        os.environ["TQDM_DISABLE"] = "1"  # read when tqdm is imported, by the command that runs


def json_object(text: str, option: str) -> dict[str, Any]:
    """Value of an option that holds a JSON object; anything else is an InputError."""
    try:
        value = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{option}: not readable as JSON ({error})") from None
    if not isinstance(value, dict):
        raise InputError(f"{option}: expected a JSON object, got {text}")
    return value
