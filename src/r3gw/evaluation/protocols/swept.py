"""Protocols that light a test view by its session's LDR map and let an oracle turn it."""

from dataclasses import asdict
from math import pi

import numpy as np
from jaxtyping import Bool, Float

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.evaluation.metrics import masked_psnr, score
from r3gw.evaluation.protocols.base import Outcome, ViewProtocol
from r3gw.evaluation.protocols.facts import FULL_YAW, NERF_OSR, NERF_OSR_LINEAR
from r3gw.evaluation.protocols.published import at_sun_angle, published_light
from r3gw.imaging.colour import GAMMA
from r3gw.model.lights import learned_strength
from r3gw.scene import EvaluationEntry, View

NUM_SUN_ANGLES = 51
NUM_CIRCLE_ANGLES = 48
NUM_EXPOSURE_STEPS = 3


class NerfOsr(ViewProtocol):
    """The published NeRF-OSR protocol: the session's LDR map, turned to the best of 51 angles.

    The angle is an oracle choice: it maximises the masked PSNR against the test photo itself.
    The map is mirrored as published (`r3gw.lighting.envmap.published_directions`), its values are
    not made linear, the sky is white.
    """

    facts = NERF_OSR

    def evaluate(self, evaluated: EvaluatedScene, view: View) -> Outcome:
        """Sweep the sun, keep the best angle; the whole curve is in the figures."""
        assert view.evaluation is not None  # covers() holds
        angles_rad = np.linspace(*view.evaluation.sun_angles_rad, NUM_SUN_ANGLES)
        return _swept(evaluated, view, view.evaluation, angles_rad)


class FullYaw(ViewProtocol):
    """`NerfOsr` with the whole circle to choose from, in steps of 7.5 degrees.

    What the published range of angles, itself prior knowledge, is worth. The same oracle chooses.
    """

    facts = FULL_YAW

    def evaluate(self, evaluated: EvaluatedScene, view: View) -> Outcome:
        """Sweep the sun around the circle, keep the best angle."""
        assert view.evaluation is not None  # covers() holds
        angles_rad = np.linspace(-pi, pi, NUM_CIRCLE_ANGLES, endpoint=False)
        return _swept(evaluated, view, view.evaluation, angles_rad)


class NerfOsrLinear(ViewProtocol):
    """`NerfOsr` with the map made linear; the oracle chooses its exposure, too.

    The published protocol takes display values for light: shade comes out too bright, and a clipped
    sun too weak beside it. Linear values know no unit, so at every angle the exposure is the one
    that suits the test photo best, for every method alike.
    """

    facts = NERF_OSR_LINEAR

    def evaluate(self, evaluated: EvaluatedScene, view: View) -> Outcome:
        """Sweep the sun, keep the best angle and exposure; ``exposure`` is relative to the map."""
        assert view.evaluation is not None  # covers() holds
        given = published_light(evaluated, view, view.evaluation, is_linear=True)
        # Clamped pictures tell no exposure, so begin where those of the training photos are.
        start = learned_strength(evaluated.model) / given.strength
        angles_rad = np.linspace(*view.evaluation.sun_angles_rad, NUM_SUN_ANGLES)
        lights = [at_sun_angle(given.times(start), angle) for angle in angles_rad]
        photo, is_scored = evaluated.photo(view), evaluated.is_scored(view)
        curve = []
        for light in lights:
            picture = evaluated.render(view, light)
            fitted = np.clip(_display_factor(picture, photo, is_scored) * picture, 0.0, 1.0)
            curve.append(masked_psnr(fitted, photo, is_scored, view.name))
        best = int(np.argmax(curve))
        gain = 1.0
        for _ in range(NUM_EXPOSURE_STEPS):
            picture = evaluated.render(view, lights[best].times(gain))
            gain *= _display_factor(picture, photo, is_scored) ** GAMMA
        chosen = lights[best].times(gain)
        picture = evaluated.render(view, chosen)
        figures = {
            **asdict(score(picture, photo, is_scored, view.name)),
            "angle_rad": float(angles_rad[best]),
            "exposure": start * gain,
            "sweep_angles_rad": angles_rad.tolist(),
            "sweep_psnr": curve,
        }
        return Outcome(picture, chosen, figures)


def _swept(
    evaluated: EvaluatedScene,
    view: View,
    entry: EvaluationEntry,
    angles_rad: Float[np.ndarray, "angles"],
) -> Outcome:
    """The view at the sun angle whose masked PSNR against the test photo is best."""
    first = published_light(evaluated, view, entry)
    photo, is_scored = evaluated.photo(view), evaluated.is_scored(view)
    curve = [
        masked_psnr(evaluated.render(view, at_sun_angle(first, angle)), photo, is_scored, view.name)
        for angle in angles_rad
    ]
    best = int(np.argmax(curve))
    light = at_sun_angle(first, angles_rad[best])
    picture = evaluated.render(view, light)
    figures = {
        **asdict(score(picture, photo, is_scored, view.name)),
        "angle_rad": float(angles_rad[best]),
        "sweep_angles_rad": angles_rad.tolist(),
        "sweep_psnr": curve,
    }
    return Outcome(picture, light, figures)


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
