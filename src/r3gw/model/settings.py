"""Settings of what the model starts from and how it shades itself; values live in config/."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from r3gw.files.strict import Strict

LEAST_CLOSED = 0.9  # opacity of a closed sky's Gaussians: they never become denser than they start


class InitSettings(Strict):
    """Values before the first iteration.

    Attributes:
        opacity: First opacity of every Gaussian.
        roughness: First roughness of every surface.
        albedo: First albedo of every surface, in all channels; "photos" takes it from the
            training photos (r3gw.training.first_values).
        light_radiance: Radiance of the first, even light; "photos" takes it from the training
            photos (r3gw.training.first_values).
    """

    opacity: float = Field(gt=0, lt=1)
    roughness: float = Field(gt=0, lt=1)
    albedo: Annotated[float, Field(gt=0, lt=1)] | Literal["photos"]
    light_radiance: Annotated[float, Field(gt=0)] | Literal["photos"]


class SkySettings(Strict):
    """The sky's initial Gaussians (Sec. 4.3).

    Attributes:
        around: What the dome holds: the "scene", as in the paper, or all training "cameras" too.
        least_opacity: Of a Gaussian of the sky, at first and while it is learned. At 0, as in the
            paper, the sky is as thin as photos leave it, and black shows where none of them looks.
        is_closed: Whether its Gaussians are spaced evenly and stay as they are placed. Else
            training opens holes in the sky, and paints with the black behind it what is dark in
            single photos: a tree, a sign. Other cameras see these holes hang in the sky.
    """

    count_per_radius: float = Field(gt=0)
    min_count: int = Field(gt=0)
    max_count: int = Field(gt=0)
    azimuth_range: str = Field(pattern="^(cameras|full)$")
    around: Literal["scene", "cameras"]
    least_opacity: float = Field(ge=0, lt=1)
    is_closed: bool

    @model_validator(mode="after")
    def _closed_is_dense(self) -> "SkySettings":
        if self.is_closed and self.least_opacity < LEAST_CLOSED:
            raise ValueError(
                f"a sky with 'is_closed: true' stays as thin as it starts: set 'least_opacity' to "
                f"at least {LEAST_CLOSED}, it is {self.least_opacity}"
            )
        return self


class StereoSettings(Strict):
    """More first points than structure from motion finds (r3gw.stereo); not in the paper."""

    enabled: bool


class OcclusionSettings(Strict):
    """Shadows that the foreground casts on itself (r3gw.model.occlusion); not in the paper."""

    enabled: bool
    first: int = Field(ge=0)
    interval: int = Field(gt=0)
    voxels: int = Field(ge=8, le=512)
    directions: int = Field(ge=8)
    reach: int = Field(ge=1)
    offset: float = Field(ge=0)
    bounce: float = Field(ge=0, lt=1)
    neighbours: int = Field(ge=1)
