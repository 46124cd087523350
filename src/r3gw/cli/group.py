"""The command group, and the kinds of option that its commands share."""

import json
import logging
import sys
from pathlib import Path
from typing import Any

import click

from r3gw.files import InputError

FOLDER = click.Path(file_okay=False, path_type=Path)
FILE = click.Path(dir_okay=False, path_type=Path)
THREADS = click.option("--threads", type=click.IntRange(1), default=1, help="CPU threads.")


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="r3gw")
def cli() -> None:
    """Relightable 3D Gaussians for outdoor scenes in the wild.

    Each stage reads and writes files; `snakemake --cores 2 all` runs them in order.
    """
    # Libraries only warn: fontTools alone writes hundreds of INFO lines per figure.
    logging.basicConfig(level=logging.WARNING, format="%(message)s", stream=sys.stderr)
    logging.getLogger("r3gw").setLevel(logging.INFO)


def json_object(text: str, option: str) -> dict[str, Any]:
    """Value of an option that holds a JSON object; anything else is an InputError."""
    try:
        value = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{option}: not readable as JSON ({error})") from None
    if not isinstance(value, dict):
        raise InputError(f"{option}: expected a JSON object, got {text}")
    return value
