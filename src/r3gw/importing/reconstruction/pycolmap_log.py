"""pycolmap's progress messages, kept off the terminal."""

from collections.abc import Iterator
from contextlib import contextmanager

import pycolmap


@contextmanager
def quiet() -> Iterator[None]:
    """Keep pycolmap's progress messages off the terminal; errors stay."""
    level = pycolmap.logging.minloglevel
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value
    try:
        yield
    finally:
        pycolmap.logging.minloglevel = level
