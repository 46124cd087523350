"""What a large run costs Snakemake itself: thousands of jobs, planned, and done by sleepers.

    python benchmarks/many_jobs.py --scenes 100 --variants 7 --seeds 5

Plans the run (`snakemake --dry-run`), and with ``--run`` does it: every command of r3gw is replaced
by one that sleeps for ``--sleep-s`` and leaves empty results. Prints jobs, seconds, seconds of
processor time and peak memory of Snakemake's own process; sleepers count in the seconds alone.
"""

import argparse
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml
from kill_test import copy_checkout

VARIANTS = [
    "full", "no_specular", "no_sky_depth", "no_sky_gaussians", "no_separation", "light_degree_2",
    "r3gw_plus",
]  # fmt: skip
# Takes the place of r3gw/__main__.py. What a command leaves: its options name the place.
SLEEPER = """
import json, sys, time
from pathlib import Path

command, words = sys.argv[1], sys.argv[2:]
option = dict(zip(words, words[1:]))
target = Path(option.get("--target", "unused"))
time.sleep({sleep_s})
made = {{
    "import": ["scene.json", "points.npz"], "masks": ["masks.json"], "doctor": ["doctor.json"],
    "train": ["model.safetensors", "history.csv", "run.json", "timing.json"],
    "evaluate": ["metrics.json", "lights.json", "relit/relit.json", "cost.json"],
    "tables": ["table1.csv", "table1.md", "table1.tex", "decomposition.csv", "cost.csv",
               "runs.csv", "images.csv"],
    "mask-sheet": [f"{{option.get('--name')}}_masks.png"],
}}.get(command, [])
if command == "generate":
    target.mkdir(parents=True, exist_ok=True)
elif command == "figures":
    from r3gw.reporting.figures.kinds import PICTURES, PLOTS
    made = [f"{{option['--name']}}_{{kind}}.png" for kind in (*PICTURES, *PLOTS)]
elif command in ("initialise", "doctor-scene", "page", "report"):
    made = [""]
size = {{"size": {{"foreground": 9000, "sky": 2000, "photos": 20, "photo_pixels": 864000}}}}
for name in made:
    path = target / name if name else target
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(size) + "\\n")
"""


def prepare(folder: Path, arguments: argparse.Namespace) -> None:
    """The workflow with sleepers, and a configuration of so many scenes, variants and seeds."""
    copy_checkout(folder)
    (folder / "src/r3gw/__main__.py").write_text(SLEEPER.format(sleep_s=arguments.sleep_s))
    scenes = {
        f"scene{number:03}": {"format": "synthetic", "building": "chapel", "seed": number}
        for number in range(arguments.scenes)
    }
    variants, seeds = VARIANTS[: arguments.variants], list(range(arguments.seeds))
    ablations = {"variants": variants, "seeds": seeds}
    config = {"scenes": scenes, "variants": variants, "seeds": seeds, "ablations": ablations}
    (folder / "mine.yaml").write_text(yaml.safe_dump(config))


def measure(folder: Path, *options: str) -> None:
    """Run Snakemake and print what it took."""
    line = [sys.executable, "-m", "snakemake", "--configfile", "mine.yaml", "--quiet", "rules"]
    environment = os.environ | {"PYTHONPATH": str(folder / "src"), "XDG_CACHE_HOME": str(folder)}
    began, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    with (folder / "run.log").open("w+") as log:
        run = subprocess.Popen([*line, *options, "--", "all"], cwd=folder, env=environment,
                               stdout=log, stderr=log)  # fmt: skip
        peak_mb, own_s = watch(run.pid, run)
        log.seek(0)
        if run.returncode != 0:
            sys.exit(f"snakemake failed ({run.returncode}):\n{log.read()[-3000:]}")
        jobs = re.findall(r"^\s*total\s+(\d+)", log.read(), re.MULTILINE)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    whole_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(
        f"{' '.join(options)}: {jobs[-1] if jobs else '?'} jobs, {time.monotonic() - began:.0f} s, "
        f"processor {own_s:.0f} s of Snakemake's and {whole_s:.0f} s with all it started, "
        f"peak {peak_mb:.0f} MB",
        flush=True,
    )


def watch(pid: int, run: subprocess.Popen[bytes]) -> tuple[float, float]:
    """Peak resident memory (MB) and processor seconds of one process, without its children's."""
    peak_mb = own_s = 0.0
    ticks = os.sysconf("SC_CLK_TCK")
    while run.poll() is None:
        try:
            status = Path(f"/proc/{pid}/status").read_text()
            fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            break
        if found := re.search(r"VmHWM:\s+(\d+)", status):
            peak_mb = max(peak_mb, int(found[1]) * 1024 / 1e6)
        own_s = max(own_s, (int(fields[11]) + int(fields[12])) / ticks)
        time.sleep(0.1)
    run.wait()
    return peak_mb, own_s


def main() -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--variants", type=int, default=len(VARIANTS))
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--run", action="store_true", help="Do the jobs, not only plan them.")
    parser.add_argument("--sleep-s", type=float, default=1.0)
    parser.add_argument("--at-once", type=int, default=200, help="Sleepers at a time.")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="r3gw-many-") as base:
        folder = Path(base).resolve() / "run"
        prepare(folder, arguments)
        measure(folder, "--dry-run")
        if arguments.run:
            measure(folder, "--cores", str(arguments.at_once))
            measure(folder, "--dry-run")


if __name__ == "__main__":
    main()
