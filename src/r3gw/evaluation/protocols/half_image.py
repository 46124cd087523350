"""The protocol ``half-image``: light is fitted to the left half of a held-out photo.

It is the protocol of NeRF in the Wild (Martin-Brualla et al. 2021) for photos whose light nobody
knows, which WildGaussians and NerfBaselines (there ``nerfw``) use too.
"""

from dataclasses import asdict, replace
from typing import Any

import numpy as np
import torch

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.evaluation.fitted_light import Target, fitted_light
from r3gw.evaluation.metrics import score
from r3gw.evaluation.protocols.base import Outcome, ViewProtocol
from r3gw.evaluation.protocols.facts import HALF_IMAGE
from r3gw.model.lights import photographed_light
from r3gw.scene import View
from r3gw.scene.selection import evenly

NUM_STARTS = 12
LEAST_PIXELS = 500  # that must be valid in each half


class HalfImage(ViewProtocol):
    """Light, sky, exposure and white balance are fitted to the left half, the scene is held.

    What is scored is the right half, which nothing was fitted to: over all valid pixels, and
    (``_foreground``) over those that are not sky.
    """

    facts = HALF_IMAGE

    def evaluate(self, evaluated: EvaluatedScene, view: View) -> Outcome | None:
        """Fit left, score right; None where either half has hardly any valid pixels."""
        photo, (is_valid, is_sky) = evaluated.photo(view), evaluated.masks(view)
        middle = view.width // 2
        is_right = np.zeros_like(is_valid)
        is_right[:, middle:] = True
        if min(is_valid[is_right].sum(), is_valid[~is_right].sum()) < LEAST_PIXELS:
            return None
        model = evaluated.model
        starts = [photographed_light(model, name) for name in evenly(model.photos, NUM_STARTS)]
        left = Target(
            replace(view.camera, width=middle),
            torch.from_numpy(photo[:, :middle]).float(),
            torch.from_numpy(is_valid[:, :middle]),
        )
        light = fitted_light(model, left, starts)
        picture = evaluated.render(view, light)
        is_scored = is_valid & is_right
        figures: dict[str, Any] = asdict(score(picture, photo, is_scored, view.name))
        is_foreground = is_scored & ~is_sky
        if is_foreground.any():
            foreground = score(picture, photo, is_foreground, view.name)
            figures["psnr_foreground"] = foreground.psnr
            figures["ssim_foreground"] = foreground.ssim
        return Outcome(picture, light, figures)
