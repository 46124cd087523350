"""Libraries that only some uses of r3gw need, and the extra of pip that installs each."""

import importlib
import re
from types import ModuleType

from r3gw.files.errors import InputError

EXTRAS = {
    "astral": "pipeline",
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


def missing_system_library(error: BaseException) -> InputError | None:
    """One sentence for a library of the operating system that a Python library did not find.

    Some libraries fail in another way in the wake of it, so what led to the error counts too.
    """
    cause: BaseException | None = error
    while cause is not None:
        found = re.match(r"(\S+): cannot open shared object file", str(cause))
        if isinstance(cause, ImportError) and found:
            return InputError(
                f"{found[1]}: this library of the operating system is not installed; install it, "
                "such as libatomic1 for libatomic.so.1 and libgomp1 for libgomp.so.1 on Debian and "
                "Ubuntu (docs/install.md)"
            )
        cause = cause.__cause__ or cause.__context__
    return None
