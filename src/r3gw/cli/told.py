"""What a command says when it has written something: one line on stderr, left out by --quiet."""

import logging
from collections.abc import Sequence
from pathlib import Path

_LOG = logging.getLogger(__name__)
OPEN_PAGE = "open it in a browser; it needs no network"


def wrote(written: Path | str | Sequence[Path], then: str = "") -> None:
    """Say what was written and, where that is not plain, what to do with it.

    Args:
        written: A path as the user gave it, several, or words that name them.
        then: How to open it, or what it is for.
    """
    named = str(written) if isinstance(written, Path | str) else ", ".join(map(str, written))
    _LOG.info("wrote %s%s", named, f": {then}" if then else "")
