"""Why jobs of Slurm's ended, in words: Snakemake is told no more than that they failed.

Snakemake keeps the log of a failed job. What the job was and what it asked for stands there, and
what Slurm's own programs say of its end.
"""

import re
from collections.abc import Iterator
from pathlib import Path

LOGS = Path(".snakemake/slurm_logs")
_REASONS = (
    (
        r"oom[-_]kill|exceeded memory limit|Out Of Memory",
        "needed more than the {mem_mb} MB of memory",
    ),
    (r"DUE TO TIME LIMIT", "took longer than the {runtime} minutes"),
)
_NODE_FAILED = r"DUE TO NODE FAILURE"


def failed_jobs(folder: Path, since_s: float) -> list[str]:
    """One sentence for each job that Slurm ended, oldest first.

    Args:
        folder: Working folder of the workflow.
        since_s: Only of logs that were written after this time (Unix time, seconds).
    """
    logs = [(path.stat().st_mtime, path) for path in (folder / LOGS).rglob("*.log")]
    return [
        sentence
        for time_s, path in sorted(logs)
        if time_s >= since_s
        for sentence in _sentences(path)
    ]


def _sentences(log: Path) -> Iterator[str]:
    text = log.read_text(errors="replace")
    asked = dict(re.findall(r"\b(mem_mb|runtime)=(\d+)", text))
    rules = re.findall(r"^(?:local)?rule (\w+):", text, re.MULTILINE)
    wildcards = re.findall(r"^ +wildcards: (.+)$", text, re.MULTILINE)
    of = f" ({wildcards[-1]})" if wildcards else ""
    job = f"{rules[-1] if rules else 'a job'}{of}"
    for pattern, reason in _REASONS:
        if re.search(pattern, text):
            what = reason.format_map({"mem_mb": "?", "runtime": "?"} | asked)
            yield f"{job} {what} that it had asked for; Slurm ended it ({log})"
            return
    if re.search(_NODE_FAILED, text):
        yield f"{job} was lost with its node ({log})"
