"""Who rasterizes: implementations of `r3gw.raster.rasterize` by name, and a default per device.

``cpp`` is the C++ rasterizer, for float32 tensors on the CPU; ``torch`` is the plain reference, for
every device and floating dtype, on small scenes. `register_backend` adds another.
"""

from collections.abc import Iterable, Sequence
from typing import Protocol, runtime_checkable

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.native import kernels
from r3gw.raster import cpp, plain
from r3gw.raster.result import RasterResult


@runtime_checkable
class Backend(Protocol):
    """An implementation of `r3gw.raster.rasterize`, whose arguments these are.

    It checks them: what is wrong raises a ValueError that names the tensor.
    """

    def __call__(
        self,
        means: Float[Tensor, "n 3"],
        quaternions: Float[Tensor, "n 4"],
        scales: Float[Tensor, "n 3"],
        opacities: Float[Tensor, " n"],
        features: Float[Tensor, "n channels"],
        cam_from_world: Float[Tensor, "rows 4"],
        intrinsics: Sequence[float],
        width: int,
        height: int,
        background: Float[Tensor, " channels"] | None,
        num_feature_gradients: int,
        pulls2d: Float[Tensor, "n 2"] | None,
    ) -> RasterResult:
        """Composite Gaussians front to back."""
        ...


_BACKENDS: dict[str, Backend] = {"cpp": cpp.rasterize, "torch": plain.rasterize}
_DEFAULTS: dict[str, str] = {"cpu": "cpp"}
_ANYWHERE = "torch"


def register_backend(name: str, backend: Backend, devices: Iterable[str] = ()) -> None:
    """Make an implementation known as ``name``.

    Args:
        name: What `rasterize` is given as ``backend``; a known name gets the new implementation.
        backend: Held to the reference as `tests/raster/test_backends.py` holds the others.
        devices: Types of devices (``torch.device.type``) whose tensors it shall rasterize unless
            the caller says otherwise.
    """
    _BACKENDS[name] = backend
    _DEFAULTS.update(dict.fromkeys(devices, name))


def backend_named(name: str | None, device: torch.device) -> Backend:
    """The implementation of a name; of None, the default of a device.

    Raises:
        ValueError: If no implementation has the name.
    """
    if name is None:
        name = _DEFAULTS.get(device.type, _ANYWHERE) if kernels.are_on() else _ANYWHERE
    if name not in _BACKENDS:
        known = ", ".join(sorted(_BACKENDS))
        raise ValueError(f"no rasterizer backend is called '{name}'; there are: {known}")
    return _BACKENDS[name]
