"""Entry point of ``python -m r3gw``; the commands are in r3gw.cli."""

import sys

import click

# Importing the modules registers their commands.
from r3gw.cli import check, data, report, runs, score, use  # noqa: F401
from r3gw.cli.group import cli
from r3gw.files import InputError
from r3gw.native.code import EXTENSION, MISSING, require_current_extension


def main() -> None:
    """Run the command line; bad input ends in one sentence and exit status 2.

    Nothing runs with kernels that are older than their sources.
    """
    try:
        require_current_extension()
        cli()
    except InputError as error:
        click.echo(f"r3gw: {error}", err=True)
        sys.exit(2)
    except ModuleNotFoundError as error:
        if error.name != EXTENSION:
            raise
        click.echo(f"r3gw: {MISSING}", err=True)
        sys.exit(2)


if __name__ == "__main__":
    main()
