"""The evaluation protocols: under which light a view is rendered, and which pixels count.

A protocol is one small class below and one entry of `PROTOCOLS`. Its ``version`` goes into every
record; raise it when its figures change.
"""

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from math import pi
from typing import Any

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.evaluation.bench import Bench
from r3gw.evaluation.lights import learned_strength, photo_light
from r3gw.evaluation.metrics import masked_psnr, score
from r3gw.evaluation.published import at_sun_angle, published_light
from r3gw.imaging.colour import GAMMA, display_array_from_linear
from r3gw.imaging.files import read_linear
from r3gw.lighting.irradiance import irradiance
from r3gw.scene import EvaluationEntry, GroundTruth, View

NUM_SUN_ANGLES = 51
NUM_CIRCLE_ANGLES = 48
NUM_EXPOSURE_STEPS = 3


@dataclass(frozen=True)
class Outcome:
    """One view under one protocol.

    Attributes:
        picture: ``[H, W, 3]`` display values.
        light: ``[coeff, 3]`` the SH light of the picture.
        sky_light: Sky coefficients of the picture; None is a white sky.
        figures: psnr, ssim, mse, mae, and what the protocol adds; JSON values.
    """

    picture: Float[np.ndarray, "h w 3"]
    light: Float[Tensor, "coeff 3"]
    sky_light: Float[Tensor, "skycoeff 3"] | None
    figures: dict[str, Any]


class ViewProtocol(ABC):
    """What a protocol has.

    Attributes:
        name: In tables and file names.
        version: Goes into every record.
        is_oracle: Whether it chooses something by looking at the photo that it is scored on.
    """

    name: str
    version: int
    is_oracle: bool = False

    @abstractmethod
    def covers(self, view: View) -> bool:
        """Whether the view has what the protocol needs."""

    @abstractmethod
    def evaluate(self, bench: Bench, view: View) -> Outcome:
        """Render and score the view."""


class NerfOsr(ViewProtocol):
    """The published NeRF-OSR protocol: the session's LDR map, turned to the best of 51 angles.

    The angle is an oracle choice: it maximises the masked PSNR against the test photo itself.
    The map is mirrored as published (data.md E), values are not linearised, the sky is white.
    """

    name = "nerf-osr"
    version = 1
    is_oracle = True

    def covers(self, view: View) -> bool:
        """Test views that come with an environment map."""
        return view.split == "test" and view.evaluation is not None

    def evaluate(self, bench: Bench, view: View) -> Outcome:
        """Sweep the sun, keep the best angle; the whole curve is in the figures."""
        assert view.evaluation is not None  # covers() holds
        angles_rad = np.linspace(*view.evaluation.sun_angles_rad, NUM_SUN_ANGLES)
        return _swept(bench, view, view.evaluation, angles_rad)


class FullYaw(NerfOsr):
    """`NerfOsr` with the whole circle to choose from, in steps of 7.5 degrees.

    What the published range of angles, itself prior knowledge, is worth. The same oracle chooses.
    """

    name = "full-yaw"
    version = 1
    is_oracle = True

    def evaluate(self, bench: Bench, view: View) -> Outcome:
        """Sweep the sun around the circle, keep the best angle."""
        assert view.evaluation is not None  # covers() holds
        angles_rad = np.linspace(-pi, pi, NUM_CIRCLE_ANGLES, endpoint=False)
        return _swept(bench, view, view.evaluation, angles_rad)


class NerfOsrLinear(NerfOsr):
    """`NerfOsr` with the map made linear; the oracle chooses its exposure, too.

    The published protocol takes display values for light: shade comes out too bright, and a clipped
    sun too weak beside it. Linear values know no unit, so at every angle the exposure is the one
    that suits the test photo best, for every method alike.
    """

    name = "nerf-osr-linear"
    version = 1
    is_oracle = True

    def evaluate(self, bench: Bench, view: View) -> Outcome:
        """Sweep the sun, keep the best angle and exposure; ``exposure`` is relative to the map."""
        assert view.evaluation is not None  # covers() holds
        given = published_light(bench, view, view.evaluation, is_linear=True)
        # Clamped pictures tell no exposure, so begin where those of the training photos are.
        start = learned_strength(bench.model) / float(given[0].mean())
        angles_rad = np.linspace(*view.evaluation.sun_angles_rad, NUM_SUN_ANGLES)
        lights = [at_sun_angle(start * given, angle) for angle in angles_rad]
        photo, is_scored = bench.photo(view), bench.is_scored(view)
        curve = []
        for light in lights:
            picture = bench.render(view, light, None)
            fitted = np.clip(_display_factor(picture, photo, is_scored) * picture, 0.0, 1.0)
            curve.append(masked_psnr(fitted, photo, is_scored, view.name))
        best = int(np.argmax(curve))
        gain = 1.0
        for _ in range(NUM_EXPOSURE_STEPS):
            picture = bench.render(view, gain * lights[best], None)
            gain *= _display_factor(picture, photo, is_scored) ** GAMMA
        light = gain * lights[best]
        picture = bench.render(view, light, None)
        figures = {
            **asdict(score(picture, photo, is_scored, view.name)),
            "angle_rad": float(angles_rad[best]),
            "exposure": start * gain,
            "sweep_angles_rad": angles_rad.tolist(),
            "sweep_psnr": curve,
        }
        return Outcome(picture, light, None, figures)


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
        light = bench.true_light(view.truth)
        photo, is_scored = bench.photo(view), bench.is_scored(view)
        picture = bench.render(view, light, None)
        oracle = diffuse_oracle(bench, view.truth, light)
        figures = {
            **asdict(score(picture, photo, is_scored, view.name)),
            "oracle_psnr": masked_psnr(oracle, photo, is_scored, view.name),
        }
        return Outcome(picture, light, None, figures)


class Learned(ViewProtocol):
    """Training views under the light and sky that were learned for them, passers-by left out."""

    name = "learned"
    version = 1

    def covers(self, view: View) -> bool:
        """Training views."""
        return view.split == "train"

    def evaluate(self, bench: Bench, view: View) -> Outcome:
        """Score all valid pixels, and once more (``psnr_foreground``) those that are not sky."""
        light, sky_light = photo_light(bench.model, view.name)
        photo, (is_valid, is_sky) = bench.photo(view), bench.masks(view)
        picture = bench.render(view, light, sky_light)
        figures: dict[str, Any] = asdict(score(picture, photo, is_valid, view.name))
        is_foreground = is_valid & ~is_sky
        if is_foreground.any():
            figures["psnr_foreground"] = masked_psnr(picture, photo, is_foreground, view.name)
        return Outcome(picture, light, sky_light, figures)


PROTOCOLS: tuple[ViewProtocol, ...] = (
    NerfOsr(),
    FullYaw(),
    NerfOsrLinear(),
    Exact(),
    Learned(),
)


def _swept(
    bench: Bench, view: View, entry: EvaluationEntry, angles_rad: Float[np.ndarray, "angles"]
) -> Outcome:
    """The view at the sun angle whose masked PSNR against the test photo is best."""
    first = published_light(bench, view, entry)
    photo, is_scored = bench.photo(view), bench.is_scored(view)
    curve = [
        masked_psnr(
            bench.render(view, at_sun_angle(first, angle), None), photo, is_scored, view.name
        )
        for angle in angles_rad
    ]
    best = int(np.argmax(curve))
    light = at_sun_angle(first, angles_rad[best])
    picture = bench.render(view, light, None)
    figures = {
        **asdict(score(picture, photo, is_scored, view.name)),
        "angle_rad": float(angles_rad[best]),
        "sweep_angles_rad": angles_rad.tolist(),
        "sweep_psnr": curve,
    }
    return Outcome(picture, light, None, figures)


def _display_factor(
    picture: Float[np.ndarray, "h w 3"],
    photo: Float[np.ndarray, "h w 3"],
    is_scored: Bool[np.ndarray, "h w"],
) -> float:
    """Factor on a picture's display values that brings it nearest to the photo (least squares).

    To the power `GAMMA` it is one on the light, where nothing is clamped.
    """
    seen, wanted = picture[is_scored], photo[is_scored]
    return float((seen * wanted).sum() / (seen * seen).sum())


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
