"""How far running stages are, for whoever watches Snakemake: a line on the terminal now and then.

Stages write their progress bars into log files, where they do not mix. This reads the ends of those
files that grew lately.
"""

import re
import time
from collections.abc import Callable
from pathlib import Path
from threading import Event, Thread

EVERY_S = 20.0
TAIL_BYTES = 4096
# What tqdm writes: "train:  12%|█▎   | 360/3000 [03:10<23:12, 1.90it/s, loss 0.1, psnr 20 dB]".
BAR = re.compile(
    r"^(?P<what>[^\r\n|]*?): +\d+%\|[^|]*\| (?P<done>\d+)/(?P<total>\d+) "
    r"\[[\d:]+<(?P<left>[\d:]+),(?P<more>[^\]\r\n]*)\]",
    re.MULTILINE,
)
ITS_NUMBERS = re.compile(r"^ *[\d.?]+ ?\S+/\w+,? *|^ *[\d.]+s/\w+,? *")  # iterations per second


def tell_progress(logs: Path, say: Callable[[str], None], every_s: float = EVERY_S) -> Event:
    """Say every now and then how far each stage is whose log grew since; returns at once.

    Args:
        logs: Folder of the stages' log files.
        say: Gets a line of text, in another thread.
        every_s: Seconds between two looks.

    Returns:
        Set it to end this; it ends with the process in any case.
    """
    ended = Event()

    def watch() -> None:
        while not ended.wait(every_s):
            for line in progress_since(logs, time.time() - every_s):
                say(line)

    Thread(target=watch, daemon=True, name="progress").start()
    return ended


def progress_since(logs: Path, since_s: float) -> list[str]:
    """One line for every log file that was written since a time (of `time.time`) and has a bar."""
    found = []
    for path in sorted(logs.rglob("*.log")):
        try:
            tail = _tail(path) if path.stat().st_mtime >= since_s else ""
        except OSError:  # taken away meanwhile
            continue
        if (line := _told(tail)) is not None:
            found.append(f"{path.relative_to(logs).with_suffix('')}: {line}")
    return found


def _tail(path: Path) -> str:
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - TAIL_BYTES))
        return file.read().decode(errors="replace").replace("\r", "\n")


def _told(tail: str) -> str | None:
    """The last bar of a log in words; None without one, or where it is full."""
    bars = list(BAR.finditer(tail))
    if not bars or bars[-1]["done"] == bars[-1]["total"]:
        return None
    bar = bars[-1]
    more = ITS_NUMBERS.sub("", bar["more"]).strip()
    line = f"{bar['what']} {bar['done']} of {bar['total']}, {bar['left']} left"
    return f"{line} ({more})" if more else line
