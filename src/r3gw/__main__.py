"""Entry point of ``r3gw`` and ``python -m r3gw``; the commands are in r3gw.cli."""

import sys

import click

# Importing the modules registers their commands.
from r3gw.cli import check, data, photos, report, runs, score, use, view  # noqa: F401
from r3gw.cli.group import cli
from r3gw.files import InputError, sentence_of
from r3gw.files.extras import missing_extra, missing_system_library
from r3gw.files.processes import end_with_owner
from r3gw.native.code import require_current_extension, require_same_code


def main() -> None:
    """Run the command line, unless its kernels are older than their sources.

    Bad input, what the operating system refuses, and a library of an extra that is not installed
    end in one sentence and exit status 2.
    """
    if (sentence := _ended_by()) is not None:
        # Said when the error's frames are gone, and with them the progress bar that was under way.
        click.echo(f"r3gw: {sentence}", err=True)
        sys.exit(2)


def _ended_by() -> str | None:
    """Run the command; the sentence that it ends with, if it does not end well."""
    try:
        end_with_owner()
        require_current_extension()
        require_same_code()
        cli()
    except InputError as error:
        return str(error)
    except OSError as error:
        return sentence_of(error)
    except MemoryError:
        return "there is not enough memory; close other programs or use smaller pictures"
    except ModuleNotFoundError as error:
        if (missing := missing_extra(error)) is error:
            raise
        return str(missing)
    except (ImportError, NameError) as error:  # drjit ends in a NameError
        if (system := missing_system_library(error)) is None:
            raise
        return str(system)
    return None


if __name__ == "__main__":
    main()
