"""Runs mutated inputs through one reader in a process of its own, whose death tells of a crash."""

import contextlib
import hashlib
import os
import random
import resource
import signal
import tempfile
import time
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from r3gw.files import InputError
from support.fuzzing.mutation import mutated
from support.fuzzing.readers import TARGETS, Target

MOST_SECONDS = 5.0  # of this process's time, for one input: a busy machine is no fault
MOST_BYTES = 6 << 30  # of memory that a reader may ask for


@dataclass(frozen=True)
class Outcome:
    """What a reader made of one input.

    Attributes:
        kind: ``read``, ``refused`` (by an InputError), ``fault`` or ``slow``.
        detail: Of a fault: the exception and where it was raised.
        seconds: Of this process's time that it took.
    """

    kind: str
    detail: str
    seconds: float


class _TooSlowError(BaseException):
    """Raised by the alarm."""


def limit_process() -> None:
    """Bound memory, and let an alarm end what takes too long."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MOST_BYTES, resource.RLIM_INFINITY))
    signal.signal(signal.SIGPROF, _too_slow)


def _too_slow(*_: object) -> None:
    raise _TooSlowError


def outcomes(name: str, seeds: range, folder: Path) -> Iterator[tuple[int, Outcome]]:
    """Mutate and read; one outcome per seed.

    Args:
        name: Of the target.
        seeds: Each gives one input, always the same.
        folder: An empty folder for the files.
    """
    target = TARGETS[name]
    target.make(folder)
    files = sorted(path for path in folder.glob(target.files) if path.is_file())
    whole = {path: path.read_bytes() for path in files}
    for seed in seeds:
        path, data = chosen(name, seed, whole)
        path.write_bytes(data)
        yield seed, _outcome(target, folder)
        path.write_bytes(whole[path])


def chosen(name: str, seed: int, whole: dict[Path, bytes]) -> tuple[Path, bytes]:
    """The file that one seed mutates, and its new bytes."""
    digest = hashlib.sha256(f"{name} {seed}".encode()).digest()
    random_ = random.Random(int.from_bytes(digest[:8], "big"))
    path = random_.choice(sorted(whole))
    return path, mutated(whole[path], random_)


def _outcome(target: Target, folder: Path) -> Outcome:
    begin = time.process_time()
    kind, detail = "read", ""
    try:
        signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", ResourceWarning)
            target.read(folder)
    except InputError as error:
        kind = "refused"
        if "\n" in str(error):
            kind, detail = "fault", f"a sentence of several lines: {error}"
    except _TooSlowError:
        kind, detail = "slow", f"more than {MOST_SECONDS} s"
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(where.filename).name}:{where.lineno}"
        kind, detail = "fault", f"{type(error).__name__} at {place}: {str(error)[:120]}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    return Outcome(kind, detail, time.process_time() - begin)


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Libraries print what they think of broken files; nobody reads it here."""
    kept = os.dup(1), os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept[0], 1)
        os.dup2(kept[1], 2)
        for descriptor in (nowhere, *kept):
            os.close(descriptor)


def run(name: str, seeds: range, record: Path) -> None:
    """Append one line per outcome to ``record``, each begun before its input is read."""
    import logging

    logging.disable(logging.CRITICAL)
    limit_process()
    with (
        silent(),
        tempfile.TemporaryDirectory(prefix="fuzz-") as folder,
        record.open("a", buffering=1) as stream,
    ):
        stream.write(f"{seeds.start} ")
        for seed, outcome in outcomes(name, seeds, Path(folder)):
            detail = " ".join(outcome.detail.split())
            stream.write(f"{outcome.kind} {outcome.seconds:.4f} {detail}\n{seed + 1} ")
