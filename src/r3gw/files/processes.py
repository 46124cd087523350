"""Processes that outlive a look at them: which one it was, whether it lives, ending with another.

A process id alone is given out again; with host, boot and start time it names one process for good.
"""

import os
import platform
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path

OWNER = "R3GW_OWNER"  # environment: the process that stages shall not outlive
RECORD = "R3GW_OWNER_RECORD"  # environment: file that is there as long as that process is
_LOOK_EVERY_S = 1.0
_OUTLIVED = 143  # as after SIGTERM


def identity(pid: int) -> str | None:
    """Name of a process of this machine for good; None if there is none of that number."""
    start = _start(pid)
    return None if start is None else "|".join((platform.node(), _boot(), str(pid), start))


def is_alive(named: str) -> bool:
    """Whether a process that `identity` named lives; one of another host is taken to."""
    host, boot, pid, start = named.split("|")
    if host != platform.node():
        return True
    return boot == _boot() and _start(int(pid)) == start


def end_with_owner() -> None:
    """End this process when the one named in the environment, or its parent, is gone.

    On another host the owner's record tells: it goes when the owner ends, or, if that was killed,
    when the next run claims the folder. Where no record can be seen nothing tells of the owner.
    Without the variable nothing happens: a stage that somebody started by hand may outlive the
    terminal.
    """
    owner = os.environ.get(OWNER)
    if owner is None:
        return
    record = Path(os.environ.get(RECORD, ""))
    if owner.startswith(f"{platform.node()}|{_boot()}|"):
        _watch(lambda: is_alive(owner))
    elif _names(record, owner):
        _watch(lambda: _names(record, owner))


def end_with_parent() -> None:
    """End this process when its parent is gone."""
    _watch(lambda: True)


def _names(record: Path, owner: str) -> bool:
    """Whether a record is there and names this owner; a file system that stutters is no answer."""
    try:
        return record.read_text() == owner
    except (FileNotFoundError, IsADirectoryError):
        return False
    except OSError:
        return True


def _watch(owner_lives: Callable[[], bool]) -> None:
    parent = os.getppid()

    def look() -> None:
        while os.getppid() == parent and owner_lives():
            time.sleep(_LOOK_EVERY_S)
        os._exit(_OUTLIVED)

    threading.Thread(target=look, daemon=True, name="end with parent").start()


def _boot() -> str:
    """What is different after every start of the machine, where the system tells."""
    path = Path("/proc/sys/kernel/random/boot_id")
    return path.read_text().strip() if path.is_file() else ""


def _start(pid: int) -> str | None:
    """When a process started, in the system's own words; None if it is gone or a mere remnant."""
    if Path("/proc/self/stat").is_file():
        try:
            fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            return None
        return None if fields[0] in "ZX" else fields[19]
    line = ["ps", "-o", "stat=,lstart=", "-p", str(pid)]
    found = subprocess.run(line, capture_output=True, text=True, check=False).stdout.split(None, 1)
    return None if not found or found[0].startswith("Z") else found[1].strip()
