"""Carrying a scene with all that turns with it into other coordinates."""

from dataclasses import replace
from math import log

import torch
from jaxtyping import Float
from scipy.spatial.transform import Rotation
from torch import Tensor

from r3gw.geometry.similarity import Similarity
from r3gw.lighting.sh_rotation import rotate
from r3gw.relight.gaussians import Relightable


def moved(gaussians: Relightable, target_from_source: Similarity) -> Relightable:
    """The same scene and its lights in the coordinates of a similarity's target."""
    rotation = target_from_source.rotation
    occlusion = gaussians.occlusion
    return replace(
        gaussians,
        means=target_from_source.points(gaussians.means),
        quaternions=_turned(gaussians.quaternions, rotation),
        log_scales=gaussians.log_scales + log(target_from_source.scale),
        lights={photo: light.rotated(rotation) for photo, light in gaussians.lights.items()},
        occlusion=None if occlusion is None else rotate(occlusion.T, rotation).T,
    )


def _turned(
    quaternions: Float[Tensor, "n 4"], rotation: Float[Tensor, "3 3"]
) -> Float[Tensor, "n 4"]:
    """Quaternions wxyz of rotations followed by ``rotation``; unit length."""
    if len(quaternions) == 0:
        return quaternions
    before = Rotation.from_quat(quaternions.double().numpy(), scalar_first=True)
    after = Rotation.from_matrix(rotation.numpy()) * before
    return torch.from_numpy(after.as_quat(scalar_first=True)).to(quaternions.dtype)
