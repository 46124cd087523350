"""Libraries that only some uses of r3gw need, and the extra of pip that installs each."""

import importlib
from types import ModuleType

from r3gw.files.errors import InputError

EXTRAS = {
    "imageio_ffmpeg": "view",
    "jinja2": "pipeline",
    "matplotlib": "pipeline",
    "mitsuba": "view",
    "mpl_toolkits": "pipeline",
    "pandas": "pipeline",
    "pycolmap": "pipeline",
    "pygments": "pipeline",
    "snakemake": "pipeline",
    "tabulate": "pipeline",
}


def optional_module(name: str) -> ModuleType:
    """Import a library of an extra.

    Raises:
        InputError: If it is not installed; the message names the extra.
    """
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        raise missing_extra(error) from error


def missing_extra(error: ModuleNotFoundError) -> Exception:
    """What to raise for a library that was not found: one sentence if an extra installs it."""
    library = (error.name or "").partition(".")[0]
    if library not in EXTRAS:
        return error
    return InputError(
        f"this needs the Python library {library}, which is not installed: "
        f"pip install 'r3gw[{EXTRAS[library]}]'"
    )
