"""Progress of stages is read from what tqdm really writes, and only where something goes on."""

import os
import time
from queue import Queue

from tqdm import tqdm

from r3gw.pipeline.progress import progress_since, tell_progress


def log_of(num_done: int, total: int, name: str, unit: str = "it", more: str = "") -> str:
    """What tqdm puts into a log after some steps, each of which took 2 s."""
    rate = 0.5 if num_done else None
    return "\r" + tqdm.format_meter(
        num_done, total, 2.0 * num_done, prefix=name, unit=unit, rate=rate, postfix=more
    )


def test_the_last_bar_of_a_log_in_words(tmp_path):
    log = tmp_path / "train" / "place.full.seed0.log"
    log.parent.mkdir()
    early = log_of(3, 9, "reading photos", "photo")
    log.write_text(early + "a line\n" + log_of(60, 300, "train", more="psnr 18 dB"))
    assert progress_since(tmp_path, 0.0) == [
        "train/place.full.seed0: train 60 of 300, 08:00 left (psnr 18 dB)"
    ]


def test_neither_what_is_done_nor_what_stands_still_is_told(tmp_path):
    (tmp_path / "done.log").write_text(log_of(9, 9, "masks"))
    (tmp_path / "begun.log").write_text(log_of(0, 9, "masks"))
    (tmp_path / "none.log").write_text("masks: 5 of 9\n")
    old = tmp_path / "old.log"
    old.write_text(log_of(4, 9, "masks"))
    assert progress_since(tmp_path, 0.0) == ["old: masks 4 of 9, 00:10 left"]
    os.utime(old, (1000.0, 1000.0))
    assert progress_since(tmp_path, 1001.0) == []


def test_a_long_log_is_read_at_its_end(tmp_path):
    log = tmp_path / "train.log"
    log.write_bytes(b"\xe2" * 10_000 + b"\r" + log_of(1, 2, "train").encode() + b"\xe2\x96")
    assert progress_since(tmp_path, 0.0) == ["train: train 1 of 2, 00:02 left"]


def test_it_goes_on_until_it_is_ended(tmp_path):
    said: Queue[str] = Queue()
    (tmp_path / "masks.log").write_text(log_of(4, 9, "masks"))
    os.utime(tmp_path / "masks.log", (time.time() + 60, time.time() + 60))
    ended = tell_progress(tmp_path, said.put, every_s=0.01)
    lines = {said.get(timeout=10), said.get(timeout=10)}
    ended.set()
    assert lines == {"masks: masks 4 of 9, 00:10 left"}
