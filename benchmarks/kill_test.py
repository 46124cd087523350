"""Kill runs of the workflow at random moments; in the end the results have the bytes of a calm run.

    python benchmarks/kill_test.py --kills 20

A small configuration with `full` and `r3gw_plus` runs once undisturbed. Then the same command is
started again and again in a second folder, and killed (SIGKILL) after a random time: the whole
process group, Snakemake alone, or one stage. When a run gets to its end, every file is compared
with the calm run's, but for what was measured, and the folder is emptied. What ran when the kill
came is counted by stage. Exit status 1 if any file differs, any run fails or any stage outlives its
run.
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
import time
from collections import Counter
from pathlib import Path

import yaml

REPOSITORY = Path(__file__).parents[1]
MEASURED = {"timing.json", "cost.json", "cost.csv"}
TARGETS = ("results/table1.csv", "results/figures/tiny_views.png")
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


def stages(folder: Path) -> dict[int, str]:
    """The stages that run in a folder, by process id."""
    found = {}
    for path in Path("/proc").glob("[0-9]*"):
        try:
            line = (path / "cmdline").read_bytes().split(b"\0")
            where = (path / "cwd").readlink()
        except OSError:
            continue
        if where == folder and line[1:3] == [b"-m", b"r3gw"]:
            found[int(path.name)] = line[3].decode()
    return found


def kill_something(run: subprocess.Popen[bytes], folder: Path, draw: random.Random) -> str:
    """Kill the group, Snakemake alone or one stage; returns which and what ran."""
    running = stages(folder)
    which = draw.choice(["group", "snakemake", "stage"] if running else ["group", "snakemake"])
    if which == "group":
        os.killpg(run.pid, signal.SIGKILL)
    elif which == "snakemake":
        run.kill()
    else:
        try:
            os.kill(draw.choice(sorted(running)), signal.SIGKILL)
        except ProcessLookupError:
            which = "stage (just ended)"
    names = " and ".join(sorted(set(running.values()))) or "snakemake itself"
    return f"{which} during {names}"


def outlived(folder: Path, seconds: float = 60.0) -> dict[int, str]:
    """Stages that still run when their run has been gone for a while."""
    deadline = time.monotonic() + seconds
    while (left := stages(folder)) and time.monotonic() < deadline:
        time.sleep(0.2)
    return left


def digests(folder: Path) -> dict[str, str]:
    """SHA-256 of every result that is not measured; hidden files are none."""
    results = folder / "results"
    return {
        str(path.relative_to(results)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(results.rglob("*"))
        if path.is_file()
        and path.name not in MEASURED
        and not any(part.startswith(".") for part in path.relative_to(results).parts)
    }


def main() -> None:
    """Run the test and print its counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--longest-s", type=float, default=40.0, help="Between start and kill.")
    arguments = parser.parse_args()
    draw = random.Random(arguments.seed)
    with tempfile.TemporaryDirectory(prefix="r3gw-kill-") as base:
        sys.exit(test(Path(base).resolve(), arguments.kills, arguments.longest_s, draw))


def test(base: Path, wanted: int, longest_s: float, draw: random.Random) -> int:
    """Kill ``wanted`` times, to the end of the last run; returns the exit status."""
    copy_checkout(base / "checkout")
    calm = prepare(base / "calm")
    if (status := start(calm).wait()) != 0:
        print(f"the calm run failed with status {status}:", (calm / "run.log").read_text())
        return 1
    expected = digests(calm)
    print(f"calm run: {len(expected)} files", flush=True)
    kills: Counter[str] = Counter()
    completed = number = faults = 0
    folder = prepare(base / f"disturbed{number}")
    while True:
        run = start(folder)
        try:
            left_s = draw.uniform(1.0, longest_s) if kills.total() < wanted else None
            status = run.wait(left_s)
        except subprocess.TimeoutExpired:
            kill = kill_something(run, folder, draw)
            kills[kill] += 1
            if kill.startswith("stage"):
                run.wait()  # Snakemake ends by itself, with the failure of that job
            else:
                run.wait()
                if left := outlived(folder):
                    print("outlived their run:", left, flush=True)
                    faults += 1
            print(f"{kills.total()}: {kill}", flush=True)
            continue
        if status != 0:
            print(f"a run that nobody killed failed ({status}):", (folder / "run.log").read_text())
            return 1
        found = digests(folder)
        different = sorted(n for n in {*found, *expected} if found.get(n) != expected.get(n))
        completed += 1
        faults += bool(different)
        print(f"completed {completed}: {len(different)} files differ {different}", flush=True)
        if kills.total() >= wanted:
            break
        shutil.rmtree(folder)
        number += 1
        folder = prepare(base / f"disturbed{number}")
    during = Counter(
        stage for kill, n in kills.items() for stage in re.split(r" and ", kill.split("during ")[1])
        for _ in range(n)
    )  # fmt: skip
    print(f"{kills.total()} kills, {completed} runs completed, {faults} faults")
    print("killed during:", ", ".join(f"{name} {count}" for name, count in during.most_common()))
    return int(faults > 0)


if __name__ == "__main__":
    main()
