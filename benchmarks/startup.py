"""What a stage costs before it does anything: processor seconds of Python and of its imports.

    python benchmarks/startup.py

Every stage imports what it runs in a fresh process; the least of several counts, since the machine
may be busy. Prints a table, with the heavy libraries that a stage loads, and writes
results/benchmarks/startup.csv.
"""

import os
import subprocess
import sys
from pathlib import Path

import pandas as pd

from r3gw.files import atomic_path

TARGET = Path("results/benchmarks/startup.csv")
ROUNDS = 5
# What a command imports when it runs (r3gw.cli).
STAGES = {
    "Python alone": "sys",
    "doctor-run": "r3gw.pipeline.doctor.training",
    "doctor": "r3gw.pipeline.doctor.doctor",
    "generate": "r3gw.benchmark.generate",
    "import": "r3gw.importing.stage",
    "masks": "r3gw.masks.stage",
    "mask-sheet": "r3gw.reporting.figures.mask_sheet",
    "initialise": "r3gw.model.stage",
    "train": "r3gw.training.run",
    "evaluate": "r3gw.evaluation.stage",
    "tables": "r3gw.reporting.tables.stage",
    "figures": "r3gw.reporting.figures.stage",
    "page": "r3gw.view.page",
    "report": "r3gw.reporting.page.stage",
}
HEAVY = ("torch", "mitsuba", "matplotlib", "pandas", "scipy", "pycolmap")
CODE = "import sys, {module}; print(*(name for name in {heavy} if name in sys.modules))"


def measure(module: str) -> tuple[float, str]:
    """Processor seconds of a process that imports a module, and the heavy libraries it loads."""
    command = [sys.executable, "-c", CODE.format(module=module, heavy=HEAVY)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    loaded = process.stdout.read().strip()
    process.stdout.close()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{module} cannot be imported")
    return usage.ru_utime + usage.ru_stime, loaded


def main() -> None:
    """Measure every stage."""
    rows = []
    for stage, module in STAGES.items():
        runs = [measure(module) for _ in range(ROUNDS)]
        rows.append({"stage": stage, "seconds": min(runs)[0], "loads": runs[0][1]})
        print(pd.DataFrame(rows[-1:]).to_string(index=False, header=len(rows) == 1), flush=True)
    with atomic_path(TARGET) as path:
        pd.DataFrame(rows).to_csv(path, index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
