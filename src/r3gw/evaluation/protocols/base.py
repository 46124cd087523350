"""What an evaluation protocol is, and what it says of a view."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from torch import Tensor

from r3gw.evaluation.bench import Bench
from r3gw.scene import View


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
