"""What the log of a failed job says, in a sentence; the lines are Slurm's own (22.05)."""

import os

import pytest

from r3gw.pipeline.slurm import LOGS, failed_jobs

JOB = """\
rule train:
    wildcards: scene=tiny, variant=full, seed=0
    resources: mem_mb=558, mem=558 MB, runtime=5
{}
Error in rule train:
"""


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            "slurmstepd-n1: error: Detected 1 oom-kill event(s) in StepId=8.0.",
            "needed more than the 558 MB of memory that it had asked for; Slurm ended it",
        ),
        (
            "slurmstepd-n1: error: StepId=1.0 exceeded memory limit (313925632 > 104857600), "
            "being killed",
            "needed more than the 558 MB of memory that it had asked for; Slurm ended it",
        ),
        (
            "slurmstepd: error: *** JOB 9 ON n1 CANCELLED AT 2026-11-26T04:43:16 DUE TO TIME LIMIT",
            "took longer than the 5 minutes that it had asked for; Slurm ended it",
        ),
        (
            "slurmstepd: error: *** JOB 9 ON n1 CANCELLED AT 2026-11-26T04:43:16 DUE TO NODE "
            "FAILURE, SEE SLURMCTLD LOG FOR DETAILS ***",
            "was lost with its node",
        ),
        ("r3gw: photo.jpg: not a picture", None),
    ],
)
def test_the_reason_is_said_with_the_job_and_what_it_asked_for(tmp_path, line, expected):
    log = tmp_path / LOGS / "rule_train/tiny_full_0/8.log"
    log.parent.mkdir(parents=True)
    log.write_text(JOB.format(line))
    job = "train (scene=tiny, variant=full, seed=0)"
    sentences = [] if expected is None else [f"{job} {expected} ({log})"]
    assert failed_jobs(tmp_path, 0.0) == sentences
    os.utime(log, (1000.0, 1000.0))
    assert failed_jobs(tmp_path, 1001.0) == []
    assert failed_jobs(tmp_path / "without", 0.0) == []
