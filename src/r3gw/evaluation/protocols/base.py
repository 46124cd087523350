"""What an evaluation protocol is, and what it says of a view."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from r3gw.evaluation.bench import Bench
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
