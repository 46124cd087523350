"""The processes of a running workflow's stages: which there are, what they used, and their end."""

import os
import signal
import subprocess
import time
from collections.abc import Collection
from pathlib import Path

LOOK_EVERY_S = 0.05


def stages(folder: Path) -> dict[int, str]:
    """The stages that run in a folder, by process id; a training with its variant."""
    found = {}
    for path in Path("/proc").glob("[0-9]*"):
        try:
            line = (path / "cmdline").read_bytes().split(b"\0")
            where = (path / "cwd").readlink()
        except OSError:
            continue
        if where == folder and line[1:3] == [b"-m", b"r3gw"]:
            words = [word.decode() for word in line[3:]]
            variant = f" {words[words.index('--variant') + 1]}" if words[0] == "train" else ""
            found[int(path.name)] = words[0] + variant
    return found


def processor_s(pid: int) -> float | None:
    """Seconds of processor time that a process has had; None if it is gone."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def watch(run: subprocess.Popen[bytes], folder: Path) -> dict[str, float]:
    """Wait for a calm run; returns processor seconds of each stage, in the order of their ends."""
    names: dict[int, str] = {}
    used: dict[int, float] = {}
    ended: dict[str, float] = {}
    while run.poll() is None:
        names |= stages(folder)
        for pid in list(names):
            if (now := processor_s(pid)) is None:
                ended.setdefault(names.pop(pid), used.pop(pid))
            else:
                used[pid] = now
        time.sleep(LOOK_EVERY_S)
    return ended


def wait_for(
    wanted: Collection[str], run: subprocess.Popen[bytes], folder: Path
) -> tuple[int, str] | None:
    """Process id and name of the first stage that runs of some; None if the run ended before."""
    while run.poll() is None:
        for pid, name in stages(folder).items():
            if name in wanted:
                return pid, name
        time.sleep(LOOK_EVERY_S)
    return None


def kill(which: str, pid: int, after_s: float, run: subprocess.Popen[bytes]) -> bool:
    """Kill when a stage has used so many processor seconds; False if it ended before."""
    while (now := processor_s(pid)) is not None and now < after_s:
        time.sleep(0.01)
    try:
        if which == "stage":
            os.kill(pid, signal.SIGKILL)
        elif which == "snakemake":
            run.kill()
        else:
            os.killpg(run.pid, signal.SIGKILL)
    except ProcessLookupError:
        return False
    return now is not None


def outlived(folder: Path, seconds: float = 60.0) -> dict[int, str]:
    """Stages that still run when their run has been gone for a while."""
    deadline = time.monotonic() + seconds
    while (left := stages(folder)) and time.monotonic() < deadline:
        time.sleep(0.2)
    return left
