"""The protocol ``exact``: a test view under its true light."""

from dataclasses import asdict
from math import pi

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.evaluation.metrics import masked_psnr, score
from r3gw.evaluation.protocols.base import Outcome, ViewProtocol
from r3gw.evaluation.protocols.facts import EXACT
from r3gw.imaging.colour import display_array_from_linear
from r3gw.imaging.files import read_linear
from r3gw.lighting.irradiance import irradiance
from r3gw.scene import GroundTruth, View


class Exact(ViewProtocol):
    """The true HDR map in its true orientation and the photo's own units; nothing is searched.

    Beside it stands an oracle that shades true albedo and normals diffusely under the same SH
    light: what a method without cast shadows can reach at best, reflections aside.
    """

    facts = EXACT

    def evaluate(self, evaluated: EvaluatedScene, view: View) -> Outcome:
        """Render under the true light; ``oracle_psnr`` bounds what to expect."""
        assert view.truth is not None  # covers() holds
        light = evaluated.true_light(view.truth)
        photo, is_scored = evaluated.photo(view), evaluated.is_scored(view)
        picture = evaluated.render(view, light)
        oracle = diffuse_oracle(evaluated, view.truth, light.sh)
        figures = {
            **asdict(score(picture, photo, is_scored, view.name)),
            "oracle_psnr": masked_psnr(oracle, photo, is_scored, view.name),
        }
        return Outcome(picture, light, figures)


def diffuse_oracle(
    evaluated: EvaluatedScene, truth: GroundTruth, light: Float[Tensor, "coeff 3"]
) -> Float[np.ndarray, "h w 3"]:
    """Display values of true albedo and normals under bands 0 to 2 of a light; sky is white."""
    albedo = read_linear(evaluated.scene_folder / truth.albedo)
    normals = read_linear(evaluated.scene_folder / truth.normal)
    received = irradiance(light, torch.from_numpy(normals).flatten(0, 1)).numpy()
    linear = albedo * received.reshape(albedo.shape) / np.float32(pi)
    is_surface = np.linalg.norm(normals, axis=-1, keepdims=True) > 0.5
    return np.where(is_surface, display_array_from_linear(linear), 1.0).astype(np.float64)
