"""The protocol ``learned``: a training view under the light that was learned for it."""

from dataclasses import asdict
from typing import Any

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.evaluation.metrics import masked_psnr, score
from r3gw.evaluation.protocols.base import Outcome, ViewProtocol
from r3gw.evaluation.protocols.facts import LEARNED
from r3gw.model.lights import photographed_light
from r3gw.scene import View


class Learned(ViewProtocol):
    """Training views under the light and sky that were learned for them, passers-by left out."""

    facts = LEARNED

    def evaluate(self, evaluated: EvaluatedScene, view: View) -> Outcome:
        """Score all valid pixels, and once more (``psnr_foreground``) those that are not sky."""
        light = photographed_light(evaluated.model, view.name)
        photo, (is_valid, is_sky) = evaluated.photo(view), evaluated.masks(view)
        picture = evaluated.render(view, light)
        figures: dict[str, Any] = asdict(score(picture, photo, is_valid, view.name))
        is_foreground = is_valid & ~is_sky
        if is_foreground.any():
            figures["psnr_foreground"] = masked_psnr(picture, photo, is_foreground, view.name)
        return Outcome(picture, light, figures)
