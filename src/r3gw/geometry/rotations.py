"""Quaternions, ``wxyz``, and rotation matrices."""

import torch
from jaxtyping import Float
from torch import Tensor


def rotation_from_quaternion(quaternions: Float[Tensor, "*batch 4"]) -> Float[Tensor, "*batch 3 3"]:
    """Return rotation matrices of quaternions ``wxyz`` of any length > 0."""
    w, x, y, z = torch.nn.functional.normalize(quaternions, dim=-1).unbind(-1)
    entries = [
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    ]  # fmt: skip
    return torch.stack(entries, dim=-1).reshape(*quaternions.shape[:-1], 3, 3)


def rotation_about_axis(axis: int, angle: float) -> Float[Tensor, "3 3"]:
    """Right-handed rotation by ``angle`` radians about axis 0 (x), 1 (y) or 2 (z), float64."""
    angle_tensor = torch.tensor(angle, dtype=torch.float64)
    cosine, sine = torch.cos(angle_tensor), torch.sin(angle_tensor)
    matrix = torch.eye(3, dtype=torch.float64)
    after, last = (axis + 1) % 3, (axis + 2) % 3
    matrix[after, after] = matrix[last, last] = cosine
    matrix[last, after], matrix[after, last] = sine, -sine
    return matrix


def shortest_axes(
    quaternions: Float[Tensor, "n 4"], log_scales: Float[Tensor, "n 3"]
) -> Float[Tensor, "n 3"]:
    """Unit normals: the rotation's column of the smallest scale (Sec. 4.2); sign arbitrary."""
    rotations = rotation_from_quaternion(quaternions)
    shortest = log_scales.detach().argmin(dim=-1)
    return rotations.gather(2, shortest[:, None, None].expand(-1, 3, 1)).squeeze(-1)
