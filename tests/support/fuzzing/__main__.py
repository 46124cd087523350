"""``python -m support.fuzzing --inputs 100000``: all readers, a table, and every fault."""

import argparse
import multiprocessing
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from multiprocessing.process import BaseProcess
from pathlib import Path

from support.fuzzing.readers import TARGETS
from support.fuzzing.worker import MOST_SECONDS, run

# Forked, since importing everything takes longer than a thousand inputs.
_FORKED = multiprocessing.get_context("fork")
_STALLED = 6 * MOST_SECONDS  # a native call that no alarm ends


@dataclass
class Tally:
    """All outcomes of one reader."""

    counts: Counter[str] = field(default_factory=Counter)
    faults: dict[str, list[int]] = field(default_factory=dict)
    slowest: float = 0.0
    seconds: float = 0.0

    def add(self, seed: int, kind: str, seconds: float, detail: str) -> None:
        """Count one outcome; a fault is told apart by what it says up to its first colon."""
        self.counts[kind] += 1
        self.slowest = max(self.slowest, seconds)
        if kind not in ("read", "refused"):
            self.faults.setdefault(f"{kind}: {detail}", []).append(seed)


def fuzz(name: str, first: int, count: int) -> Tally:
    """Run one reader, starting a new process behind every input that ended one."""
    tally, begin = Tally(), time.perf_counter()
    seed, last = first, first + count
    with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
        record = Path(folder) / "record"
        while seed < last:
            record.unlink(missing_ok=True)
            process = _FORKED.Process(target=run, args=(name, range(seed, last), record))
            process.start()
            status = _watched(process, record)
            lines = record.read_text(errors="replace").split("\n") if record.exists() else [""]
            for line in lines[:-1]:
                number, kind, seconds, *detail = line.split(" ", 3)
                tally.add(int(number), kind, float(seconds), "".join(detail))
                seed = int(number) + 1
            if seed < last:
                tally.add(seed, "crash", 0.0, f"exit status {status}")
                seed += 1
    tally.seconds = time.perf_counter() - begin
    return tally


def _watched(process: BaseProcess, record: Path) -> int | str | None:
    """The exit status; ``stalled`` if the process had to be ended."""
    size, since = -1, time.monotonic()
    while process.is_alive():
        process.join(0.2)
        now = record.stat().st_size if record.exists() else 0
        if now != size:
            size, since = now, time.monotonic()
        elif time.monotonic() - since > _STALLED:
            process.kill()
            process.join()
            return "stalled"
    return process.exitcode


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=100_000, help="over all readers")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--only", default="", help="readers whose name contains this")
    options = parser.parse_args()
    chosen = {name: target for name, target in TARGETS.items() if options.only in name}
    share = options.inputs / sum(target.weight for target in chosen.values())
    begin, total, faults = time.perf_counter(), Counter[str](), 0
    print(f"{'reader':26} inputs    read refused faults  slowest   time", flush=True)
    for name, target in chosen.items():
        count = -int(-share * target.weight // 1)
        tally = fuzz(name, options.first, count)
        wrong = count - tally.counts["read"] - tally.counts["refused"]
        faults += wrong
        total.update(tally.counts)
        print(
            f"{name:26} {count:6d} {tally.counts['read']:7d} {tally.counts['refused']:7d} "
            f"{wrong:6d} {tally.slowest:6.2f} s {tally.seconds:4.0f} s",
            flush=True,
        )
        for text, seeds in sorted(tally.faults.items(), key=lambda each: -len(each[1])):
            print(f"    {len(seeds)} times, first of seed {seeds[0]}: {text}", flush=True)
    minutes = (time.perf_counter() - begin) / 60
    print(f"{sum(total.values())} inputs in {minutes:.1f} min: {faults} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
