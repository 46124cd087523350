"""Entry point of ``python -m r3gw``; the commands are in r3gw.cli."""

import sys

import click

# Importing the modules registers their commands.
from r3gw.cli import check, data, report, runs, score, use  # noqa: F401
from r3gw.cli.group import cli
from r3gw.files import InputError, sentence_of


def main() -> None:
    """Run the command line.

    Bad input, and what the operating system refuses, end in one sentence and exit status 2.
    """
    try:
        cli()
    except InputError as error:
        _stop(str(error))
    except OSError as error:
        _stop(sentence_of(error))
    except MemoryError:
        _stop("there is not enough memory; close other programs or use smaller pictures")


def _stop(sentence: str) -> None:
    click.echo(f"r3gw: {sentence}", err=True)
    sys.exit(2)


if __name__ == "__main__":
    main()
