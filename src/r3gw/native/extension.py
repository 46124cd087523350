"""Loads the compiled extension, which registers the kernels as ``torch.ops.r3gw``.

Of several the best is taken that this processor can run. The environment's ``R3GW_KERNELS`` names
the levels to choose from, such as ``v2 v3``, so that the kernels of a lower level can be tested.
"""

import os
from pathlib import Path

import torch

from r3gw.files import InputError
from r3gw.native.levels import (
    BUILD,
    MISSING,
    NEEDS,
    Extension,
    best_extension,
    built_extensions,
    processor_features,
)


def chosen_extension(package: Path) -> Extension:
    """The extension that a process loads on this machine.

    Raises:
        InputError: If the package holds none, or none that the processor can run and
            ``R3GW_KERNELS`` allows.
    """
    extensions = built_extensions(package)
    if not extensions:
        raise InputError(f"{package}: {MISSING}")
    allowed = os.environ.get("R3GW_KERNELS", "").split() or NEEDS
    chosen = best_extension(extensions, processor_features(), allowed)
    if chosen is None:
        levels = ", ".join(each.level for each in extensions)
        raise InputError(
            f"{package}: holds kernels for {levels}, of which this processor runs none that "
            f"R3GW_KERNELS ({' '.join(allowed)}) allows; {BUILD}"
        )
    return chosen


def _load() -> str:
    """Load the extension for this machine; the level that it was compiled for."""
    chosen = chosen_extension(Path(__file__).parents[1])
    torch.ops.load_library(chosen.path)  # type: ignore[no-untyped-call]
    return chosen.level


LEVEL = _load()
