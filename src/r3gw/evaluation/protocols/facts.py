"""What every protocol says of itself; tables, figures and the report follow from it.

Facts stand apart from the classes that render and score (`r3gw.evaluation.protocols.registry`), so
that tables are written without loading what renders.
"""

from dataclasses import dataclass
from typing import Literal

from r3gw.scene import View


@dataclass(frozen=True, kw_only=True)
class ProtocolFacts:
    """One protocol.

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
    version: int = 1
    is_oracle: bool = False
    split: Literal["train", "test"] = "test"
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


NERF_OSR = ProtocolFacts(
    name="nerf-osr",
    is_oracle=True,
    needs=("evaluation",),
    suffix="",
    title="published angles, the best chosen by an oracle",
    light_title="nerf-osr",
    rank=2,
    gain_column="sweep_gain_psnr",
    is_pictured=True,
    study_metrics=("psnr", "ssim"),
)
FULL_YAW = ProtocolFacts(
    name="full-yaw",
    is_oracle=True,
    needs=("evaluation",),
    suffix="_full_yaw",
    title="whole circle, the best angle chosen by an oracle",
    light_title="full-yaw",
    rank=3,
    gain_column="full_yaw_gain_psnr",
)
NERF_OSR_LINEAR = ProtocolFacts(
    name="nerf-osr-linear",
    is_oracle=True,
    needs=("evaluation",),
    suffix="_linear",
    title="linear maps, angle and exposure by an oracle",
    light_title="nerf-osr-linear",
    rank=4,
    study_metrics=("psnr",),
)
EXACT = ProtocolFacts(
    name="exact",
    needs=("truth",),
    suffix="_exact",
    title="true light, nothing chosen",
    light_title="true light",
    rank=0,
    extra_fields=("oracle_psnr",),
    is_pictured=True,
    study_metrics=("psnr", "ssim"),
)
HALF_IMAGE = ProtocolFacts(
    name="half-image",
    is_oracle=True,  # by the half of the photo that is not scored
    suffix="_half",
    title="light fitted to the photo's left half, its right half scored",
    light_title="light of the left half",
    rank=5,
    extra_fields=("psnr_foreground", "ssim_foreground"),
    is_pictured=True,
    study_metrics=("psnr", "ssim"),
)
LEARNED = ProtocolFacts(
    name="learned",
    split="train",
    suffix="_learned",
    title="training views under their own lights",
    light_title="learned light",
    rank=1,
    extra_fields=("psnr_foreground",),
    is_pictured=True,
    study_metrics=("psnr",),
)

# In the order in which tables show them.
PROTOCOLS = (NERF_OSR, FULL_YAW, NERF_OSR_LINEAR, EXACT, HALF_IMAGE, LEARNED)
