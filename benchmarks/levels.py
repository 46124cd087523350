"""The same training on kernels of several levels and numbers of threads: how far results differ.

    python benchmarks/levels.py results/chapel results/chapel/full/seed0/settings.json v2 v3 v4 v4:2

Trains and scores a scene of the workflow once for each argument, a level of r3gw's kernels
(`r3gw.native.levels`; a wheel holds several) with its threads, and prints the number of Gaussians,
the mean PSNR of the test views, and how far every stored number is from the first run's.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from safetensors.numpy import load_file


def r3gw(level: str, *arguments: str) -> None:
    """Run a command of r3gw on kernels of one level."""
    environment = os.environ | {"R3GW_KERNELS": level}
    line = [sys.executable, "-m", "r3gw", *arguments]
    subprocess.run(line, env=environment, check=True, capture_output=True)


def train(scene: Path, settings: Path, level: str, threads: str, target: Path) -> None:
    """Train and score one run."""
    inputs = ["--scene", str(scene / "scene"), "--masks", str(scene / "masks")]
    rest = ["--initial", str(scene / "initial.npz"), "--settings", str(settings), "--variant", "v"]
    where = ["--name", scene.name, "--target", str(target), "--threads", threads]
    r3gw(level, "train", *inputs, *rest, *where)
    model = ["--model", str(target / "model.safetensors"), "--target", str(target / "metrics")]
    r3gw(level, "evaluate", *inputs, *model, "--threads", threads)


def scores(target: Path) -> dict[str, float]:
    """Mean PSNR of the test views by protocol, in dB."""
    images = json.loads((target / "metrics/metrics.json").read_text())["images"]
    protocols = sorted({image["protocol"] for image in images})
    return {
        protocol: float(np.mean([i["psnr"] for i in images if i["protocol"] == protocol]))
        for protocol in protocols
    }


def difference(first: Path, other: Path) -> str:
    """How far two models are apart: bytes, or the root mean square by array."""
    if first.read_bytes() == other.read_bytes():
        return "the same bytes"
    a, b = load_file(first), load_file(other)
    if any(a[name].shape != b[name].shape for name in a):
        return "another number of Gaussians"
    apart = {
        name: float(np.sqrt(np.mean((a[name].astype(float) - b[name].astype(float)) ** 2)))
        for name in a
        if np.issubdtype(a[name].dtype, np.floating) and a[name].size
    }
    return ", ".join(f"{name} {value:.1e}" for name, value in apart.items() if value > 0)


def main() -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", type=Path)
    parser.add_argument("settings", type=Path)
    parser.add_argument("runs", nargs="+", help="LEVEL or LEVEL:THREADS")
    parser.add_argument("--target", type=Path, help="Keep the runs in this folder.")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        base = arguments.target or Path(temporary)
        first: Path | None = None
        for run in arguments.runs:
            level, _, threads = run.partition(":")
            target = base / run.replace(":", "-")
            train(arguments.scene, arguments.settings, level, threads or "1", target)
            model = target / "model.safetensors"
            first = first or model
            record = json.loads((target / "run.json").read_text())
            count = record["num_foreground"] + record["num_sky"]
            shown = ", ".join(f"{name} {value:.4f}" for name, value in scores(target).items())
            print(f"{run}: {count} Gaussians; {shown}", flush=True)
            print(f"    from the first: {difference(first, model)}", flush=True)


if __name__ == "__main__":
    main()
