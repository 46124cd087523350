"""r3gw: relightable 3D Gaussians for outdoor scenes in the wild.

The names of `__all__` are the library (docs/python.md); a name's module is imported when the name
is first used, so that ``import r3gw`` takes no time. Their types stand in __init__.pyi.
"""

import os
from importlib import import_module
from typing import Any

# Waiting OpenMP threads sleep instead of spinning. With as many threads as cores, and two thread
# pools (torch's autograd has its own), spinning costs milliseconds per parallel loop as soon as
# anything else runs. Read once, when torch loads its OpenMP runtime; the user's own value wins.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

__version__ = "0.1.0"

# As strings: an import statement would make every stage of the workflow depend on all of them.
_HOMES = {
    "Camera": "r3gw.geometry.cameras",
    "InputError": "r3gw.files.errors",
    "Light": "r3gw.lighting.light",
    "RasterResult": "r3gw.raster.result",
    "Scores": "r3gw.evaluation.metrics",
    "TrainedScene": "r3gw.relight.trained",
    "export": "r3gw.relight.export",
    "load": "r3gw.relight.trained",
    "rasterize": "r3gw.raster.api",
    "score": "r3gw.evaluation.metrics",
}
__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    """Import the module that a public name lives in (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module 'r3gw' has no attribute '{name}'")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
