"""Kill runs of the workflow in every stage; in the end the results have the bytes of a calm run.

    python benchmarks/kill_test.py --rounds 1

A small configuration with `full` and `r3gw_plus` runs once undisturbed, which tells the stages and
how much processor time each takes. In every round each stage is killed twice, each training three
times: the same command is started, and the first stage that it comes to of those still to be killed
is hit at a random moment of its work. SIGKILL goes to the whole process group, to that stage alone,
or to Snakemake alone. Whenever the command comes to its end, every file is compared with the calm
run's, but for what was measured. Exit status 1 if any file differs, any run fails or any stage
outlives its run.
"""

import argparse
import hashlib
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import yaml
from stage_processes import kill, outlived, wait_for, watch

REPOSITORY = Path(__file__).parents[1]
MEASURED = {"timing.json", "cost.json", "cost.csv"}
COST = re.compile(rb"<h2[^>]*>Cost.*?(?=<h2)", re.DOTALL)  # that section of report.html
TARGETS = ("all",)
KILLS, TRAINING_KILLS = 2, 3  # of each stage and each training, in every round
CONFIG = {
    "scenes": {
        "tiny": {
            "format": "synthetic", "building": "chapel", "width_px": 64, "height_px": 48,
            "train_views": 6, "test_views": 2, "samples": 1,
        }
    },
    "variants": ["full", "r3gw_plus"],
    "seeds": [0],
    "ablations": {"variants": ["full"], "seeds": [0]},
    "train": {
        "iterations": 200,
        "density": {"max_gaussians": 6000},
        "sky": {"min_count": 100, "max_count": 200},
    },
}  # fmt: skip


def copy_checkout(target: Path) -> Path:
    """What the workflow is made of, so that an edit meanwhile changes nothing."""
    without = shutil.ignore_patterns("__pycache__", "*.egg-info", ".snakemake")
    for name in ("workflow", "config", "profiles", "src"):
        shutil.copytree(REPOSITORY / name, target / name, ignore=without)
    shutil.copy(REPOSITORY / "Snakefile", target)
    return target


def start(folder: Path) -> subprocess.Popen[bytes]:
    """Start the workflow in a process group of its own."""
    line = [sys.executable, "-m", "snakemake", "--cores", "2", "--configfile", "mine.yaml"]
    environment = os.environ | {
        "PYTHONPATH": str(folder.parent / "checkout" / "src"),
        "R3GW_CHECKPOINT_SECONDS": "2",
        "XDG_CACHE_HOME": str(folder / "cache"),
    }
    with (folder / "run.log").open("ab") as log:
        return subprocess.Popen(
            [*line, "--", *TARGETS], cwd=folder, stdout=log, stderr=log,
            start_new_session=True, env=environment,
        )  # fmt: skip


def prepare(folder: Path) -> Path:
    """A folder with the workflow and the small configuration."""
    folder.mkdir(parents=True)
    for name in ("workflow", "config", "profiles", "Snakefile"):
        (folder / name).symlink_to(folder.parent / "checkout" / name)
    (folder / "mine.yaml").write_text(yaml.safe_dump(CONFIG))
    return folder


def digests(folder: Path) -> dict[str, str]:
    """SHA-256 of every result that is not measured; hidden files are none."""
    results = folder / "results"
    return {
        str(path.relative_to(results)): hashlib.sha256(COST.sub(b"", path.read_bytes())).hexdigest()
        for path in sorted(results.rglob("*"))
        if path.is_file()
        and path.name not in MEASURED
        and not any(part.startswith(".") for part in path.relative_to(results).parts)
    }


class Disturbed:
    """Kills in one folder after another, until every stage has had its kills."""

    def __init__(self, base: Path, processor_s: Mapping[str, float], expected: Mapping[str, str]):
        """Begin in an empty folder; ``processor_s`` and ``expected`` are the calm run's."""
        self.base, self.processor_s, self.expected = base, processor_s, expected
        self.kills: list[tuple[str, str]] = []
        self.faults = self.number = 0
        self.folder = prepare(base / "disturbed0")

    def kill_all(self, wanted: dict[str, list[str]], draw: random.Random) -> None:
        """Kill each stage as often as ``wanted`` has kinds for it, then let a run come to its end.

        Each start of the command kills the first stage that it comes to of those still wanted.
        """
        while True:
            left = {stage: kinds for stage, kinds in wanted.items() if kinds}
            run = start(self.folder)
            found = wait_for(left, run, self.folder)
            if found is None:
                self.compare(run.wait())
                if not left:
                    return
                continue
            pid, stage = found
            which = left[stage][-1]
            after_s = draw.uniform(0.0, 0.95) * self.processor_s[stage]
            is_hit = kill(which, pid, after_s, run)
            if not is_hit and run.poll() is None:
                os.killpg(run.pid, signal.SIGKILL)
            run.wait()
            if alive := outlived(self.folder):
                print("outlived their run:", alive, flush=True)
                self.faults += 1
            if is_hit:
                left[stage].pop()
                self.kills.append((stage, which))
                print(f"{len(self.kills)}: {which} in {stage} after {after_s:.2f} s", flush=True)

    def compare(self, status: int) -> None:
        """Compare what a run made that came to its end, and go on in an empty folder."""
        if status != 0:
            # The same command would fail again, for ever: nothing is left to be learnt.
            log = (self.folder / "run.log").read_text()
            sys.exit(f"a run that nobody killed failed ({status}): {log}")
        found, expected = digests(self.folder), self.expected
        different = sorted(n for n in {*found, *expected} if found.get(n) != expected.get(n))
        self.faults += bool(different)
        print(f"run to the end: {len(different)} of {len(expected)} files differ {different}")
        shutil.rmtree(self.folder)
        self.number += 1
        self.folder = prepare(self.base / f"disturbed{self.number}")


def main() -> None:
    """Run the test and print its counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    draw = random.Random(arguments.seed)
    with tempfile.TemporaryDirectory(prefix="r3gw-kill-") as base:
        sys.exit(test(Path(base).resolve(), arguments.rounds, draw))


def test(base: Path, rounds: int, draw: random.Random) -> int:
    """Kill all stages ``rounds`` times; returns the exit status."""
    copy_checkout(base / "checkout")
    calm = prepare(base / "calm")
    run = start(calm)
    used = watch(run, calm)
    if run.returncode != 0:
        print(f"the calm run failed ({run.returncode}):", (calm / "run.log").read_text())
        return 1
    expected = digests(calm)
    print(f"calm run: {len(expected)} files, {len(used)} stages", flush=True)
    disturbed = Disturbed(base, used, expected)
    for _ in range(rounds):
        kinds = ["group", "stage", "snakemake"]
        wanted = {
            stage: draw.sample(kinds, TRAINING_KILLS if "train " in stage else KILLS)
            for stage in used
        }
        disturbed.kill_all(wanted, draw)
    kills, faults = disturbed.kills, disturbed.faults
    print(f"{len(kills)} kills, {disturbed.number} runs to the end, {faults} faults")
    for title, names in (("stage", [s for s, _ in kills]), ("kind", [k for _, k in kills])):
        counts = ", ".join(f"{name} {count}" for name, count in Counter(names).items())
        print(f"by {title}: {counts}")
    return int(faults > 0)


if __name__ == "__main__":
    main()
