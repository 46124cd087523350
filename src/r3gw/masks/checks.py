"""Are masks plausible? Empty or full ones, wrong polarity, too little coverage: one sentence each.

Sky is above ground: a mask whose True pixels lie lower than its False ones shows it upside down
or, far more often, has its colours the wrong way round.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError

Mask = NDArray[np.bool_]
Polarity = Literal["upright", "inverted", "unclear"]
MADE_HERE = ("classical", "none", "all")  # sources whose polarity cannot be wrong

_CLEAR = 0.1  # difference of shares from which a guess of the polarity is made
_LEAST_VALID = 0.5  # share of valid pixels over a scene that is usual
_THIRD = 3


@dataclass(frozen=True)
class MaskFacts:
    """What is known of one mask.

    Attributes:
        source: Where it came from.
        share: Share of True pixels.
        polarity: Whether a sky mask looks upright or inverted; None for other kinds.
        transparent: Share that is False because the photo is transparent there.
        levels: What the values of the user's file were, where that may explain the mask.
    """

    source: str
    share: float
    polarity: Polarity | None = None
    transparent: float = 0.0
    levels: str | None = None

    @property
    def origin(self) -> str:
        """The source, and what is known of the file behind it, for sentences."""
        return self.source if self.levels is None else f"{self.source}, {self.levels}"

    def as_json(self) -> dict[str, object]:
        """For masks.json."""
        record: dict[str, object] = {"source": self.source, "share": round(self.share, 6)}
        if self.polarity is not None:
            record["polarity"] = self.polarity
        if self.transparent:
            record["transparent"] = round(self.transparent, 6)
        return record


def sky_facts(is_sky: Mask, source: str, levels: str | None = None) -> MaskFacts:
    """Facts of a sky mask ``[H, W]``."""
    return MaskFacts(source, float(is_sky.mean()), guess_polarity(is_sky), levels=levels)


def guess_polarity(is_sky: Mask) -> Polarity:
    """Compare the share of sky in the upper and the lower third of a mask ``[H, W]``."""
    third = max(1, len(is_sky) // _THIRD)
    difference = float(is_sky[:third].mean() - is_sky[-third:].mean())
    if abs(difference) < _CLEAR:
        return "unclear"
    return "upright" if difference > 0 else "inverted"


def check_photo(name: str, is_sky: MaskFacts, is_valid: MaskFacts) -> list[str]:
    """Warnings about the masks of one photo.

    Raises:
        InputError: If nothing is valid, or everything is sky: such a photo teaches nothing.
    """
    if is_valid.share == 0.0:
        raise InputError(
            f"mask is_valid of {name} ({is_valid.origin}): every pixel is an occluder or "
            "transparent, so the photo teaches nothing; white must mean valid: correct the mask or "
            "remove the photo"
        )
    if is_sky.share == 1.0:
        raise InputError(
            f"mask is_sky of {name} ({is_sky.origin}): every pixel is sky, so the photo teaches "
            "no building; correct the mask or remove the photo"
        )
    warnings = []
    if is_sky.share == 0.0 and is_sky.source != "none":
        warnings.append(
            f"mask is_sky of {name} ({is_sky.origin}) is without any sky; look at the photo"
        )
    if is_sky.polarity == "inverted":
        warnings.append(
            f"mask is_sky of {name} ({is_sky.origin}) has more sky in its lower third than in its "
            "upper one; look whether it is inverted"
        )
    return warnings


def check_scene(sky: Mapping[str, MaskFacts], valid: Mapping[str, MaskFacts]) -> list[str]:
    """Warnings about all masks of a scene, by name of the photo.

    Raises:
        InputError: If most of the sky masks that came from outside look inverted.
    """
    judged = [
        facts.polarity
        for facts in sky.values()
        if facts.source not in MADE_HERE and facts.polarity != "unclear"
    ]
    inverted = judged.count("inverted")
    if inverted > len(judged) / 2:
        raise InputError(
            f"{inverted} of {len(judged)} sky masks have more sky in their lower third than in "
            "their upper one: they look inverted; give them the polarity that docs/data.md "
            "describes for this format"
        )
    outside = [facts.share for facts in valid.values() if facts.source not in MADE_HERE]
    if outside and (mean := float(np.mean(outside))) < _LEAST_VALID:
        return [
            f"only {mean:.0%} of the pixels of {len(outside)} occluder masks are valid; if white "
            "means occluder in them, invert them"
        ]
    return []
