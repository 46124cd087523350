"""Whether a compiled kernel does the work, or its plain form in torch.

Every fused operator has a plain form that computes the same from torch's own operators, on any
device and in any floating dtype. A caller asks here which of the two to use: the kernel where one
is registered for the tensors' device, they are float32 and kernels are not switched off.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache

import torch
from torch import Tensor

import r3gw.native.extension  # noqa: F401  Registers torch.ops.r3gw.

# torch's dispatch keys of device types whose key is not the type in capitals.
_KEYS = {"meta": "Meta", "privateuseone": "PrivateUse1"}

_ARE_ON: ContextVar[bool] = ContextVar("kernels_are_on", default=True)


def take(operator: str, *tensors: Tensor) -> bool:
    """Whether the kernel of an operator takes these tensors; otherwise its plain form has to.

    Args:
        operator: Name below ``torch.ops.r3gw``.
        tensors: Those of its arguments, of floating point, that decide.
    """
    return _ARE_ON.get() and all(
        tensor.dtype == torch.float32 and _is_registered(operator, tensor.device.type)
        for tensor in tensors
    )


@contextmanager
def switched_off() -> Iterator[None]:
    """Within this context every computation takes its plain form."""
    token = _ARE_ON.set(False)
    try:
        yield
    finally:
        _ARE_ON.reset(token)


def are_on() -> bool:
    """Whether kernels are used where there are any."""
    return _ARE_ON.get()


@cache
def _is_registered(operator: str, device_type: str) -> bool:
    """Whether the operator has an implementation for a type of device."""
    key = _KEYS.get(device_type, device_type.upper())
    return bool(torch._C._dispatch_has_kernel_for_dispatch_key(f"r3gw::{operator}", key))
