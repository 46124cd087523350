"""Where a result came from: code version, machine, settings digest, peak memory."""

import hashlib
import json
import platform
import resource
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import r3gw


def code_version() -> str:
    """Package version, with the git commit where the package runs from a checkout."""
    here = Path(__file__).parent
    command = ["git", "-C", str(here), "describe", "--always", "--dirty", "--abbrev=10"]
    try:
        found = subprocess.run(command, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return r3gw.__version__
    return f"{r3gw.__version__}+{found.stdout.strip()}"


def machine() -> str:
    """Processor model and architecture."""
    model = platform.processor() or "unknown processor"
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        names = [line for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        model = names[0].split(":", 1)[1].strip() if names else model
    return f"{model} ({platform.machine()})"


def digest(settings: Mapping[str, Any]) -> str:
    """First 12 hex digits of the SHA-256 of settings as sorted JSON."""
    text = json.dumps(settings, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def peak_rss_mb() -> float:
    """Largest resident memory of this process so far, in MB (10^6 bytes)."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
