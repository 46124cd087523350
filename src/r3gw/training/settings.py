"""Hyperparameters of one training. Values live in config/train.yaml; here are names and limits."""

from pathlib import Path
from typing import Literal

from pydantic import Field

from r3gw.files.strict import Strict, read_yaml, validated
from r3gw.model.limits import LARGEST_LAYER
from r3gw.model.settings import (
    InitSettings,
    OcclusionSettings,
    SkySettings,
    StereoSettings,
)

# How losses are computed: by kernels, or in plain torch (r3gw.training.losses.forms).
FormName = Literal["fused", "plain"]

# What `short_run_boost` multiplies.
SLOW_RATES = ("albedo", "roughness", "sky_radius", "embedding", "mlp")


class ModelSettings(Strict):
    """What is modelled, and the noise and dropout under which it is learned."""

    separate_sky: bool
    specular: bool
    light_degree: Literal[2, 4]
    share_session_light: bool
    embedding_size: int = Field(ge=1, le=LARGEST_LAYER)
    hidden_size: int = Field(ge=1, le=LARGEST_LAYER)
    light_hidden_size: int = Field(ge=1, le=LARGEST_LAYER)
    dropout: float = Field(ge=0, lt=1)
    light_noise: float = Field(ge=0)


class RateSettings(Strict):
    """Adam's learning rates."""

    position_first: float = Field(gt=0)
    position_last: float = Field(gt=0)
    position_iterations: int = Field(gt=0)
    spatial_scale: float = Field(gt=0)
    opacity: float = Field(gt=0)
    scale: float = Field(gt=0)
    rotation: float = Field(gt=0)
    albedo: float = Field(gt=0)
    roughness: float = Field(gt=0)
    sky_radius: float = Field(gt=0)
    embedding: float = Field(gt=0)
    mlp: float = Field(gt=0)
    short_run_boost: float = Field(ge=1)
    late_share: float = Field(gt=0, le=1)
    late_from: int = Field(ge=0)

    def named(self, name: str) -> float:
        """A rate at the first iteration: "position", or a field, boosted if it is a slow one."""
        if name == "position":
            return self.position_first * self.spatial_scale
        rate: float = getattr(self, name)
        return rate * self.short_run_boost if name in SLOW_RATES else rate


class WeightSettings(Strict):
    """Weights of the losses (Eq. 12-17); 0 switches a loss off."""

    ssim: float = Field(ge=0, le=1)
    light: float = Field(ge=0)
    normal: float = Field(ge=0)
    given_normal: float = Field(ge=0)
    scale: float = Field(ge=0)
    separation: float = Field(ge=0)
    sky_depth: float = Field(ge=0)
    sky_depth_gamma: float = Field(gt=0)
    sky_slope: float = Field(ge=0)
    light_directions: int = Field(ge=1)
    light_domain: Literal["hemisphere", "sphere"]
    light_average: Literal["all", "negative"]


class DensitySettings(Strict):
    """Clone, split, prune and opacity reset.

    No resets where the interval is null; a threshold whose last value is null keeps the first.
    ``gradient`` says how a view's pixels add up to what is held against the threshold: with
    their signs (net), or without (absolute; Ye et al., 2024). ``growth`` says who is densified:
    all above the threshold until ``max_gaussians`` are there (threshold), or the strongest, as many
    each time as reach that number at the last densification (even).
    """

    gradient: Literal["net", "absolute"]
    growth: Literal["threshold", "even"]
    first: int = Field(ge=0)
    last: int = Field(ge=0)
    interval: int = Field(gt=0)
    threshold_first: float = Field(gt=0)
    threshold_last: float | None = Field(gt=0)
    large_scale: float = Field(gt=0)
    huge_scale: float = Field(gt=0)
    min_opacity: float = Field(gt=0, lt=1)
    reset_interval: int | None = Field(gt=0)
    reset_opacity: float = Field(gt=0, lt=1)
    max_gaussians: int = Field(gt=0)
    sky_share: float = Field(gt=0, le=1)


class ResolutionSettings(Strict):
    """Smaller photos at first (r3gw.training.resolution); not in the paper.

    Attributes:
        smallest: Sides of the photos at first, as a share of their own; 1: whole from the start.
        whole_from: Iteration of the paper's schedule from which on they are whole.
    """

    smallest: float = Field(gt=0, le=1)
    whole_from: int = Field(ge=0)


class SilhouetteSettings(Strict):
    """The foreground's opacity in place of Eq. 15 (`silhouette_loss`); not in the paper."""

    enabled: bool
    solid: float = Field(ge=0)


class OutdoorSettings(Strict):
    """Sun, sky and ground instead of free light (r3gw.lighting.outdoor); not in the paper."""

    enabled: bool
    ground_reflectance: float = Field(ge=0, le=1)
    sun_power: float = Field(gt=0)
    sun_rate: float = Field(gt=0)
    visible_sky: float = Field(ge=0)
    sky_gradient: float = Field(ge=0)


class DaylightSettings(Strict):
    """A point sun under the CIE's skies, over the ground of `OutdoorSettings`; not in the paper.

    Attributes:
        enabled: Whether light is made of them. The other settings of sun, ground and sky are
            those of ``outdoor``, whose own switch does not matter then.
        sun_bounce: Of the sun's irradiance, what a surface gets from others that stand in the sun,
            where they hide all of the sky.
        sharp: Share of the sun whose shadows are sharp; the rest is shaded by its SH.
        shadow_age: Iterations of the paper's schedule after which shadows are cast anew.
        reach_age: Iterations of the paper's schedule for which a photo keeps how much of the sun
            reaches each Gaussian, while Gaussians neither come nor go and the sun hardly moves.
        suns: Whether suns are learned, or known where date, time and place tell them
            (r3gw.training.known_suns).
        suns_tied_from: Iteration of the paper's schedule from which on known suns are tied
            together.
    """

    enabled: bool
    suns: Literal["learned", "known"]
    suns_tied_from: int = Field(gt=0)
    sun_bounce: float = Field(ge=0, le=1)
    sharp: float = Field(ge=0, le=1)
    shadow_age: int = Field(ge=1)
    reach_age: int = Field(ge=1)


class GainsSettings(Strict):
    """Exposure and white balance of each photo, apart from its light; not in the paper.

    Attributes:
        enabled: Whether photos have them.
        steady: Weight: gains stay near 1.
        alike: Weight: lights of photos are alike in brightness and colour, so that a cast that
            either could explain is the camera's.
        warmth: Share of that for red against blue, by which daylights differ.
    """

    enabled: bool
    steady: float = Field(ge=0)
    alike: float = Field(ge=0)
    warmth: float = Field(ge=0, le=1)


class UnseenSettings(Strict):
    """Bounds on Gaussians that no photo sees well (r3gw.training.unseen); not in the paper.

    Attributes:
        enabled: Whether they act.
        nearest: Least distance from a camera, as a share of the median over Gaussians.
        widest: Largest scale, as a share of the distance to the nearest camera.
    """

    enabled: bool
    nearest: float = Field(ge=0, lt=1)
    widest: float = Field(gt=0)


class OccluderSettings(Strict):
    """Occluders found while training (r3gw.training.occluders); not in the paper.

    Attributes:
        enabled: Whether they are looked for.
        first: Iteration of the paper's schedule in which they are found first.
        interval: Iterations of the paper's schedule after which they are found anew.
        contrast: How much more unlike its rendering than other photos of the same surfaces are to
            theirs (r3gw.training.disagreement) an occluder is.
        most: Largest share of a photo that may be an occluder.
    """

    enabled: bool
    first: int = Field(ge=0)
    interval: int = Field(gt=0)
    contrast: float = Field(gt=0)
    most: float = Field(gt=0, le=1)


class DroppingSettings(Strict):
    """Gaussians left out at random while training (r3gw.training.dropping); not in the paper.

    Attributes:
        share: Of the foreground, in the last iteration; it grows evenly from 0. 0 drops none.
    """

    share: float = Field(ge=0, lt=1)


class TrainSettings(Strict):
    """Everything that changes the result of one training."""

    iterations: int = Field(ge=1)
    paper_iterations: int = Field(ge=1)
    losses: FormName
    warm_up: int = Field(ge=0)
    geometry_losses_from: int = Field(ge=0)
    seed: int = Field(ge=0)
    model: ModelSettings
    init: InitSettings
    rates: RateSettings
    weights: WeightSettings
    density: DensitySettings
    resolution: ResolutionSettings
    sky: SkySettings
    stereo: StereoSettings
    silhouette: SilhouetteSettings
    occlusion: OcclusionSettings
    outdoor: OutdoorSettings
    daylight: DaylightSettings
    unseen: UnseenSettings
    gains: GainsSettings
    dropping: DroppingSettings
    occluders: OccluderSettings


def load_train_settings(path: Path) -> TrainSettings:
    """Read the resolved settings of one run (``settings.json``; JSON is YAML too).

    Raises:
        InputError: If a key is unknown, missing or out of range.
    """
    return validated(TrainSettings, read_yaml(path), str(path))
