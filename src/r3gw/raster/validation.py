"""Checks of what a caller gives to the rasterizer: one ValueError naming tensor, count and rule.

Shapes are checked here and not by annotations, because a user runs without a type checker. One pass
in C++ (`is_usable`) tells whether anything is wrong; what follows says what.
"""

import math
from collections.abc import Sequence

import torch
from torch import Tensor

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.

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
    """Raise ValueError for the first thing that is wrong with a rasterization's arguments."""
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
    values = (means, quaternions, scales, opacities, features)
    check_gaussians(*(tensor.contiguous() for tensor in values))


def check_shapes(tensors: dict[str, tuple[Tensor, tuple[int | None, ...]]]) -> None:
    """Raise ValueError for a tensor that is not float32 on the CPU or not of its shape.

    Args:
        tensors: Name → (tensor, expected shape); None stands for any positive size.
    """
    for name, (tensor, shape) in tensors.items():
        if tensor.dtype != torch.float32 or tensor.device.type != "cpu":
            raise ValueError(
                f"{name} must be a float32 tensor on the CPU, got {tensor.dtype} on {tensor.device}"
            )
        if len(tensor.shape) != len(shape) or any(
            size != wanted if wanted is not None else size < 1
            for size, wanted in zip(tensor.shape, shape, strict=True)
        ):
            text = ", ".join("any" if size is None else str(size) for size in shape)
            raise ValueError(f"{name} must have shape [{text}], got {list(tensor.shape)}")


def check_values(name: str, tensor: Tensor, low: float, high: float, rule: str) -> None:
    """Raise ValueError if values of a contiguous tensor are NaN or outside [low, high]."""
    count: int = torch.ops.r3gw.count_outside(tensor, low, high)
    if count:
        raise ValueError(f"{name} must be {rule}: {count} of {tensor.numel()} values are not")


def check_gaussians(
    means: Tensor, quaternions: Tensor, scales: Tensor, opacities: Tensor, features: Tensor
) -> None:
    """Raise ValueError for NaN, infinite or out-of-range parameters (contiguous tensors)."""
    everything = (-_FLOAT32_MAX, _FLOAT32_MAX, "finite")
    check_values("means", means, *everything)
    check_values("quaternions", quaternions, *everything)
    check_values("scales", scales, 0.0, _FLOAT32_MAX, "finite and not negative")
    check_values("opacities", opacities, 0.0, 1.0, "in [0, 1]")
    check_values("features", features, *everything)
    count: int = torch.ops.r3gw.count_zero_quaternions(quaternions)
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
