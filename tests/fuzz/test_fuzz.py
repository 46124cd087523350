"""A little of `make fuzz`: readers read whole files and refuse mutated ones in a sentence."""

import os
import random
import signal

import numpy as np
import pytest
from support.fuzzing.__main__ import fuzz
from support.fuzzing.mutation import mutated
from support.fuzzing.readers import TARGETS, Target


@pytest.mark.parametrize("name", TARGETS)
def test_whole_files_are_read(tmp_path, name):
    TARGETS[name].make(tmp_path)
    TARGETS[name].read(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["photo.png", "map.exr", "colmap.bin", "transforms.json"])
def test_mutated_files_are_read_or_refused(name):
    tally = fuzz(name, first=0, count=60)
    assert tally.faults == {}
    assert tally.counts["read"] + tally.counts["refused"] == 60
    assert tally.counts["refused"] > 5


@pytest.mark.parametrize(
    ("read", "fault"),
    [
        (lambda _: 1 // 0, "fault: ZeroDivisionError"),
        (lambda _: os.kill(os.getpid(), signal.SIGSEGV), "crash: exit status -11"),
        (lambda _: np.zeros(1 << 40), "fault: MemoryError"),
    ],
)
def test_faults_are_found(monkeypatch, read, fault):
    target = Target(lambda folder: (folder / "a").write_bytes(b"x"), read)
    monkeypatch.setitem(TARGETS, "made", target)
    tally = fuzz("made", first=0, count=3)
    (text,) = tally.faults
    assert text.startswith(fault)
    assert tally.faults[text] == [0, 1, 2]


def test_the_same_seed_mutates_alike():
    data = b"a text of 3 numbers: 1.5 -2 7\n" * 9
    made = [mutated(data, random.Random(seed)) for seed in (1, 1, 2)]
    assert made[0] == made[1] != made[2]
