"""The compiled extensions that a package may hold, and which of them a processor can run.

A checkout holds one, compiled for the machine that it stands on (``native``). A wheel for x86-64
holds one for each level of that architecture from ``v2`` on, and elsewhere one for any processor
of its architecture (``generic``). `setup.py` runs this file before r3gw can be imported, so it
needs the standard library alone.
"""

import platform
from collections.abc import Collection, Sequence
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import NamedTuple

BUILD = "build it again: `make`, or `python setup.py build_ext --inplace` in the checkout"
MISSING = f"the compiled extension r3gw._C is missing; {BUILD}"

# Beyond the level below, as Linux calls them: x86-64 psABI, "Micro-Architecture Levels". Linux
# lists a feature only if it saves the feature's registers, so these can really be used.
_V2 = {"cx16", "lahf_lm", "popcnt", "pni", "sse4_1", "sse4_2", "ssse3"}
_V3 = {"abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe", "xsave"}
_V4 = {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}

# What a level needs of the processor, best level first: the order in which they are preferred.
NEEDS: dict[str, frozenset[str]] = {
    "native": frozenset(),
    "v4": frozenset(_V2 | _V3 | _V4),
    "v3": frozenset(_V2 | _V3),
    "v2": frozenset(_V2),
    "generic": frozenset(),
}


class Extension(NamedTuple):
    """A compiled extension and the level that it was compiled for."""

    level: str
    path: Path


def portable_levels() -> tuple[str, ...]:
    """The levels that together run on every machine with this machine's architecture."""
    return ("v4", "v3", "v2") if platform.machine() == "x86_64" else ("generic",)


def module_name(level: str) -> str:
    """Name of a level's extension in the package: ``_C``, ``_C_v3``."""
    return "_C" if level == "native" else f"_C_{level}"


def machine_flag(level: str) -> list[str]:
    """The compiler's flag that asks for a level, in a list; ``generic`` needs none."""
    machine = {"native": "native", "generic": ""}.get(level, f"x86-64-{level}")
    return [f"-march={machine}"] if machine else []


def built_extensions(package: Path) -> list[Extension]:
    """The extensions that a package holds, best level first."""
    return [
        Extension(level, path)
        for level in NEEDS
        for suffix in EXTENSION_SUFFIXES
        if (path := package / f"{module_name(level)}{suffix}").is_file()
    ]


def best_extension(
    extensions: Sequence[Extension], features: Collection[str], allowed: Collection[str] = NEEDS
) -> Extension | None:
    """The first of some extensions that a processor can run; None if it can run none.

    Args:
        extensions: Best level first.
        features: What the processor has, as `processor_features` names it.
        allowed: Levels to choose from.
    """
    return next(
        (each for each in extensions if each.level in allowed and NEEDS[each.level] <= {*features}),
        None,
    )


def processor_features(cpuinfo: Path = Path("/proc/cpuinfo")) -> frozenset[str]:
    """What Linux says that this machine's processor has; empty where Linux does not say."""
    if not cpuinfo.is_file():
        return frozenset()
    lines = cpuinfo.read_text().splitlines()
    flags = next((line for line in lines if line.startswith("flags")), ":")
    return frozenset(flags.partition(":")[2].split())
