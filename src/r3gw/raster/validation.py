"""Checks of what a caller gives to the rasterizer: one ValueError naming tensor, count and rule.

Shapes are checked here and not by annotations, because a user runs without a type checker. The C++
backend asks one pass over all values (`r3gw.native.ops.is_usable`) whether anything is wrong, and
comes here to learn what.
"""

import math
from collections.abc import Sequence

import torch
from torch import Tensor

MAX_SIDE_PX = 1 << 16
_FLOAT32_MAX = torch.finfo(torch.float32).max


def check(
    means: Tensor,
    quaternions: Tensor,
    scales: Tensor,
    opacities: Tensor,
    features: Tensor,
    background: Tensor | None,
    cam_from_world: Tensor,
    intrinsics: Sequence[float],
    width: int,
    height: int,
) -> None:
    """Raise ValueError for the first thing that is wrong with a rasterization's arguments.

    All tensors have the dtype and the device of ``means``, which every backend may restrict.
    """
    n = len(means)
    check_shapes(
        {
            "means": (means, (n, 3)),
            "quaternions": (quaternions, (n, 4)),
            "scales": (scales, (n, 3)),
            "opacities": (opacities, (n,)),
            "features": (features, (n, None)),
            "cam_from_world": (cam_from_world, (None, 4)),
        }
        | ({} if background is None else {"background": (background, (features.shape[-1],))})
    )
    check_camera(cam_from_world, intrinsics, width, height)
    check_gaussians(means, quaternions, scales, opacities, features)


def check_kind(means: Tensor, dtype: torch.dtype, device_type: str) -> None:
    """Raise ValueError unless the tensors' kind, that of ``means``, is what a backend takes."""
    if means.dtype != dtype or means.device.type != device_type:
        raise ValueError(
            f"means must be a {_name(dtype)} tensor on a device of type {device_type} for this "
            f"backend, got {_name(means.dtype)} on {means.device}"
        )


def check_shapes(tensors: dict[str, tuple[Tensor, tuple[int | None, ...]]]) -> None:
    """Raise ValueError for a tensor of another kind than the first, or not of its shape.

    Args:
        tensors: Name → (tensor, expected shape); None stands for any positive size.
    """
    first = next(iter(tensors.values()))[0]
    if not first.is_floating_point():
        raise ValueError(f"{next(iter(tensors))} must be floating, got {_name(first.dtype)}")
    for name, (tensor, shape) in tensors.items():
        if tensor.dtype != first.dtype or tensor.device != first.device:
            raise ValueError(
                f"{name} must be a {_name(first.dtype)} tensor on {first.device} as "
                f"{next(iter(tensors))} is, got {_name(tensor.dtype)} on {tensor.device}"
            )
        if len(tensor.shape) != len(shape) or any(
            size != wanted if wanted is not None else size < 1
            for size, wanted in zip(tensor.shape, shape, strict=True)
        ):
            text = ", ".join("any" if size is None else str(size) for size in shape)
            raise ValueError(f"{name} must have shape [{text}], got {list(tensor.shape)}")


def _name(dtype: torch.dtype) -> str:
    return str(dtype).removeprefix("torch.")


def check_values(name: str, tensor: Tensor, low: float, high: float, rule: str) -> None:
    """Raise ValueError if values of a tensor are NaN or outside [low, high]."""
    count = int((~((tensor >= low) & (tensor <= high))).sum())
    if count:
        raise ValueError(f"{name} must be {rule}: {count} of {tensor.numel()} values are not")


def check_gaussians(
    means: Tensor, quaternions: Tensor, scales: Tensor, opacities: Tensor, features: Tensor
) -> None:
    """Raise ValueError for NaN, infinite or out-of-range parameters."""
    everything = (-_FLOAT32_MAX, _FLOAT32_MAX, "finite")
    check_values("means", means, *everything)
    check_values("quaternions", quaternions, *everything)
    check_values("scales", scales, 0.0, _FLOAT32_MAX, "finite and not negative")
    check_values("opacities", opacities, 0.0, 1.0, "in [0, 1]")
    check_values("features", features, *everything)
    # In float32, as the kernels take them: a square may be too small for it.
    length2 = quaternions.detach().float().square().sum(-1)
    count = int((length2 < torch.finfo(torch.float32).tiny).sum())
    if count:
        raise ValueError(
            f"quaternions must have a length above 0: {count} of {len(quaternions)} have not"
        )


def check_camera(
    cam_from_world: Tensor, intrinsics: Sequence[float], width: int, height: int
) -> None:
    """Raise ValueError for a camera that is not finite or an image of no or absurd size."""
    if cam_from_world.shape not in ((3, 4), (4, 4)):
        raise ValueError(
            f"cam_from_world must have shape [3, 4] or [4, 4], got {list(cam_from_world.shape)}"
        )
    if cam_from_world.requires_grad:
        raise ValueError("cam_from_world must not require a gradient: poses are not optimised")
    if not torch.isfinite(cam_from_world).all():
        raise ValueError("cam_from_world must be finite")
    if len(intrinsics) != 4 or not all(math.isfinite(value) for value in intrinsics):
        raise ValueError(f"intrinsics must be four finite numbers, got {list(intrinsics)}")
    if min(intrinsics[0], intrinsics[1]) <= 0:
        raise ValueError(f"focal lengths must be positive, got {intrinsics[0]}, {intrinsics[1]}")
    if not (1 <= width <= MAX_SIDE_PX and 1 <= height <= MAX_SIDE_PX):
        raise ValueError(f"width and height must be in 1..{MAX_SIDE_PX}, got {width} x {height}")
