"""Snakemake's lock of a working folder, which a killed run leaves behind.

Every run names itself beside the lock before it takes it. A lock is taken away when all runs that
named themselves are gone. While one lives, or where nobody is named, Snakemake's refusal stands.
"""

import atexit
import logging
import os
import platform
import shutil
from pathlib import Path

from r3gw.files import atomic_path
from r3gw.files.processes import OWNER, RECORD, identity, is_alive

_LOG = logging.getLogger(__name__)
_OWNERS, _LOCKS = Path(".snakemake/owners"), Path(".snakemake/locks")


def claim(folder: Path) -> dict[str, str]:
    """Name this process as one that may hold the lock of ``folder``; clear a lock of the dead.

    Args:
        folder: Working folder of the workflow.

    Returns:
        What stages shall find in their environment, to end with this process (`end_with_owner`).
    """
    own = identity(os.getpid())
    assert own is not None  # it lives
    owners = folder.resolve() / _OWNERS
    owners.mkdir(parents=True, exist_ok=True)
    earlier = {path: path.read_text() for path in owners.iterdir() if not path.name.startswith(".")}
    record = owners / f"{platform.node()}.{os.getpid()}"
    with atomic_path(record) as path:
        path.write_text(own)
    atexit.register(record.unlink, missing_ok=True)
    gone = [path for path, name in earlier.items() if not is_alive(name)]
    if earlier and len(gone) == len(earlier):
        _clear(folder / _LOCKS)
    for path in gone:
        if path != record:
            path.unlink(missing_ok=True)
    return {OWNER: own, RECORD: str(record)}


def _clear(locks: Path) -> None:
    if locks.is_dir() and any(locks.iterdir()):
        _LOG.warning("%s: the run that held this lock is gone; its lock is taken away", locks)
        shutil.rmtree(locks)
