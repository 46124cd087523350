"""What an evaluation protocol is, and what it says of a view."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.evaluation.protocols.facts import ProtocolFacts
from r3gw.lighting.light import Light
from r3gw.scene import View


@dataclass(frozen=True)
class Outcome:
    """One view under one protocol.

    Attributes:
        picture: ``[H, W, 3]`` display values.
        light: What lit the picture, and the sky that it shows.
        figures: psnr, ssim, mse, mae, and what the protocol adds; JSON values.
    """

    picture: Float[np.ndarray, "h w 3"]
    light: Light
    figures: dict[str, Any]


class ViewProtocol(ABC):
    """Renders and scores one view.

    Attributes:
        facts: What the protocol says of itself.
    """

    facts: ProtocolFacts

    @abstractmethod
    def evaluate(self, evaluated: EvaluatedScene, view: View) -> Outcome | None:
        """Render and score a view that it covers; None if the photo's masks leave nothing to."""
