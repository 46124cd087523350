"""The evaluation protocols: under which light a view is rendered, and which pixels count.

A protocol is one small class, here or in r3gw.evaluation.protocols.swept, and one entry of
`PROTOCOLS`. Its ``version`` goes into every record; raise it when its figures change.
"""

from dataclasses import asdict
from math import pi
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.evaluation.bench import Bench
from r3gw.evaluation.metrics import masked_psnr, score
from r3gw.evaluation.protocols.base import Outcome, ViewProtocol
from r3gw.evaluation.protocols.swept import FullYaw, NerfOsr, NerfOsrLinear
from r3gw.imaging.colour import display_array_from_linear
from r3gw.imaging.files import read_linear
from r3gw.lighting.irradiance import irradiance
from r3gw.lighting.light import Light
from r3gw.model.lights import photo_light
from r3gw.scene import GroundTruth, View


class Exact(ViewProtocol):
    """The true HDR map in its true orientation and the photo's own units; nothing is searched.

    Beside it stands an oracle that shades true albedo and normals diffusely under the same SH
    light: what a method without cast shadows can reach at best, reflections aside.
    """

    name = "exact"
    version = 1

    def covers(self, view: View) -> bool:
        """Test views with ground truth."""
        return view.split == "test" and view.truth is not None

    def evaluate(self, bench: Bench, view: View) -> Outcome:
        """Render under the true light; ``oracle_psnr`` bounds what to expect."""
        assert view.truth is not None  # covers() holds
        light = Light(bench.true_light(view.truth))
        photo, is_scored = bench.photo(view), bench.is_scored(view)
        picture = bench.render(view, light)
        oracle = diffuse_oracle(bench, view.truth, light.sh)
        figures = {
            **asdict(score(picture, photo, is_scored, view.name)),
            "oracle_psnr": masked_psnr(oracle, photo, is_scored, view.name),
        }
        return Outcome(picture, light, figures)


class Learned(ViewProtocol):
    """Training views under the light and sky that were learned for them, passers-by left out."""

    name = "learned"
    version = 1

    def covers(self, view: View) -> bool:
        """Training views."""
        return view.split == "train"

    def evaluate(self, bench: Bench, view: View) -> Outcome:
        """Score all valid pixels, and once more (``psnr_foreground``) those that are not sky."""
        light = photo_light(bench.model, view.name)
        photo, (is_valid, is_sky) = bench.photo(view), bench.masks(view)
        picture = bench.render(view, light)
        figures: dict[str, Any] = asdict(score(picture, photo, is_valid, view.name))
        is_foreground = is_valid & ~is_sky
        if is_foreground.any():
            figures["psnr_foreground"] = masked_psnr(picture, photo, is_foreground, view.name)
        return Outcome(picture, light, figures)


PROTOCOLS: tuple[ViewProtocol, ...] = (
    NerfOsr(),
    FullYaw(),
    NerfOsrLinear(),
    Exact(),
    Learned(),
)


def diffuse_oracle(
    bench: Bench, truth: GroundTruth, light: Float[Tensor, "coeff 3"]
) -> Float[np.ndarray, "h w 3"]:
    """Display values of true albedo and normals under bands 0 to 2 of a light; sky is white."""
    albedo = read_linear(bench.scene_folder / truth.albedo)
    normals = read_linear(bench.scene_folder / truth.normal)
    received = irradiance(light, torch.from_numpy(normals).flatten(0, 1)).numpy()
    linear = albedo * received.reshape(albedo.shape) / np.float32(pi)
    is_surface = np.linalg.norm(normals, axis=-1, keepdims=True) > 0.5
    return np.where(is_surface, display_array_from_linear(linear), 1.0).astype(np.float64)
