"""The scene's frame: which way is up, where the origin is, how long a unit is.

Up is the direction that makes the photos level: hardly any roll (people hold the horizon
straight) and moderate pitch, both counted robustly, since a photo may have been taken upright.
"""

from math import radians

import numpy as np
import torch
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.geometry.cameras import UP
from r3gw.geometry.similarity import Similarity
from r3gw.importing.source import SourcePoints

# Usual sizes. Pitch is only there for photos that all look one way, where roll says nothing of
# it; tourists tilt their cameras up at a building, so it must not weigh more.
_ROLL_DEG = 1.0
_PITCH_DEG = 30.0
_ITERATIONS = 100
_PERCENTILE = 99

Matrices = NDArray[np.float64]
Vector = NDArray[np.float64]


def up_direction(cam_from_source: Matrices) -> Vector:
    """Estimate the world's up from rotations ``[N, 3, 3]``; a unit vector in the source frame.

    Minimises the Cauchy loss of roll and pitch, in units of their usual size, by iteratively
    reweighted least squares; starts from the geometric median of the cameras' up vectors.
    """
    right, down, forward = (cam_from_source[:, axis] for axis in range(3))
    up = _geometric_median(-down)
    for _ in range(_ITERATIONS):
        roll = right @ up / np.sin(radians(_ROLL_DEG))
        pitch = forward @ up / np.sin(radians(_PITCH_DEG))
        # One weight for both terms: a photo turned by 90 degrees must not vote for its forward.
        weight = 1.0 / (1.0 + roll**2 + pitch**2)
        normal = np.einsum("n,ni,nj->ij", weight / np.sin(radians(_ROLL_DEG)) ** 2, right, right)
        normal += np.einsum(
            "n,ni,nj->ij", weight / np.sin(radians(_PITCH_DEG)) ** 2, forward, forward
        )
        smallest = np.linalg.eigh(normal)[1][:, 0]
        updated = smallest if smallest @ up > 0 else -smallest
        if np.linalg.norm(updated - up) < 1e-12:
            break
        up = updated
    return up


def upright_rotation(cam_from_source: Matrices) -> Matrices:
    """Rotation ``scene_from_source`` ``[3, 3]``: up becomes -y, the photos' mean view +z.

    The second half fixes the turn about up, so that the scene does not depend on the frame in
    which the photos were registered. Photos that look all around cancel out; then the first
    photo looks along +z.
    """
    up = up_direction(cam_from_source)
    forward = cam_from_source[:, 2]
    level = forward - (forward @ up)[:, None] * up
    ahead = level.mean(axis=0)
    if np.linalg.norm(ahead) < 0.05:
        ahead = level[np.linalg.norm(level, axis=1).argmax()]
    ahead = ahead / np.linalg.norm(ahead)
    return np.stack([np.cross(-up, ahead), -up, ahead])


def roll_deg(cam_from_source: Matrices, up: Vector) -> Vector:
    """How far each camera's right vector leaves the horizon, in degrees ``[N]``."""
    return np.degrees(np.arcsin(np.clip(cam_from_source[:, 0] @ up, -1.0, 1.0)))


def scene_from_source(
    points: SourcePoints, rotation: Matrices | None, extent: float | None
) -> Similarity:
    """The similarity that turns by ``rotation`` (None: not at all) and scales to ``extent``.

    With an extent, the 99th percentile of the points' distance from their mean becomes
    ``extent`` and their mean the origin; None keeps scale and origin.

    Raises:
        InputError: If the points all lie in one place.
    """
    turn = torch.eye(3, dtype=torch.float64) if rotation is None else torch.from_numpy(rotation)
    if extent is None:
        return Similarity(1.0, turn, torch.zeros(3, dtype=torch.float64))
    xyz = torch.from_numpy(points.xyz)
    mean = xyz.mean(dim=0)
    distance = float(np.percentile((xyz - mean).norm(dim=1).numpy(), _PERCENTILE))
    if distance <= 0:
        raise InputError(
            f"the scene's {len(xyz)} points all lie in one place, so it cannot be scaled to "
            f"extent {extent:g}; check the SfM model"
        )
    scale = extent / distance
    return Similarity(scale, turn, -scale * turn @ mean)


def _geometric_median(vectors: Vector) -> Vector:
    """Weiszfeld's iteration for unit vectors ``[N, 3]``; returns a unit vector."""
    median = vectors.mean(axis=0)
    for _ in range(_ITERATIONS):
        weight = 1.0 / np.maximum(np.linalg.norm(vectors - median, axis=1), 1e-9)
        median = (weight[:, None] * vectors).sum(axis=0) / weight.sum()
    length = float(np.linalg.norm(median))
    return median / length if length > 1e-9 else np.asarray(UP, dtype=np.float64)
