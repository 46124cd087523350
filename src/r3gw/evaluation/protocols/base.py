"""What an evaluation protocol is, and what it says of a view."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from r3gw.evaluation.evaluated_scene import EvaluatedScene
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
    """What every protocol says of itself; tables, figures and the report follow from it.

    Attributes:
        name: What records and file names call it.
        version: Goes into every record; raise it when the protocol's figures change.
        is_oracle: Whether it chooses something by looking at the photo that it is scored on.
        split: Which views it is for.
        needs: Fields of `r3gw.scene.View` that a view must have, such as ``truth``.
        suffix: End of its columns' names: ``psnr<suffix>``, ``ssim<suffix>`` and so on.
        title: What it does, in a few words; stands above its part of table 1.
        light_title: Under which light a view is seen; stands above pictures and in studies.
        rank: How well it shows a view: a view's picture is that of the lowest rank it has.
        extra_fields: Figures of its own that are averaged, into columns ``<field><suffix>``.
        gain_column: Column of what it brings over the true light (mean PSNR in dB); None for none.
        is_pictured: Whether its pictures stand in the figure of views and in the report.
        study_metrics: The metrics by which a study compares.
    """

    name: str
    version: int
    is_oracle: bool = False
    split: Literal["train", "test"]
    needs: tuple[str, ...] = ()
    suffix: str
    title: str
    light_title: str
    rank: int
    extra_fields: tuple[str, ...] = ()
    gain_column: str | None = None
    is_pictured: bool = False
    study_metrics: tuple[str, ...] = ()

    def covers(self, view: View) -> bool:
        """Whether the view is of the right split and has what the protocol needs."""
        has_all = all(getattr(view, field) is not None for field in self.needs)
        return view.split == self.split and has_all

    @abstractmethod
    def evaluate(self, evaluated: EvaluatedScene, view: View) -> Outcome | None:
        """Render and score a view that it covers; None if the photo's masks leave nothing to."""
