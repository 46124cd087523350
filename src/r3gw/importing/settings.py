"""Where a scene is imported from and how: the keys of its entry in config.yaml about its source."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal
from zoneinfo import available_timezones

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, TypeAdapter, ValidationError, field_validator

from r3gw.benchmark.settings import BenchmarkSettings
from r3gw.files import InputError
from r3gw.files.strict import Strict
from r3gw.importing.source import Axes


class Place(Strict):
    """Where photos were taken, and what their clocks showed, for photos that do not say so.

    Attributes:
        latitude_deg: North is positive.
        longitude_deg: East is positive.
        time_zone: Name in the IANA data base, such as Europe/Berlin; None leaves photos without
            the sun that do not tell theirs.
    """

    latitude_deg: float = Field(ge=-90, le=90)
    longitude_deg: float = Field(ge=-180, le=180)
    time_zone: str | None = None

    @field_validator("time_zone")
    @classmethod
    def _is_known(cls, name: str | None) -> str | None:
        if name is not None and name not in available_timezones():
            raise ValueError(f"'{name}' is no time zone; write a name such as Europe/Berlin")
        return name


class SyntheticScene(BenchmarkSettings):
    """A scene of the embedded benchmark, made by the project itself."""

    format: Literal["synthetic"]
    max_image_px: int = Field(1600, ge=16)
    extent: float | None = Field(None, gt=0)
    normals: Axes = "opencv"

    def benchmark(self) -> BenchmarkSettings:
        """What is rendered, without how it is imported."""
        return BenchmarkSettings(
            **{key: getattr(self, key) for key in BenchmarkSettings.model_fields}
        )


class NerfOsrScene(Strict):
    """A NeRF-OSR scene as LumiGauss prepared it (docs/data.md)."""

    format: Literal["nerf-osr"]
    path: str
    max_image_px: int = Field(1600, ge=16)
    extent: float | None = Field(None, gt=0)
    evaluated_views: list[str] = Field(default_factory=list)
    place: Place | None = None
    normals: Axes = "opencv"


def _only_names(value: Any) -> Any:
    """Refuse names that YAML has read as numbers: without digits of theirs, they name no photo."""
    if isinstance(value, list) and (
        numbers := [each for each in value if not isinstance(each, str)]
    ):
        raise ValueError(f"a list holds names; put '{numbers[0]}' and others of digits into quotes")
    return value


HoldOut = Annotated[
    Annotated[int, Field(ge=2)] | Annotated[list[str], Field(min_length=1)] | None,
    BeforeValidator(_only_names),
]


class UnsplitScene(Strict):
    """A format that need not say which photos are for training.

    Attributes:
        hold_out: Which photos are scored instead: one of every so many, or names (their paths,
            with or without folders and suffix). None takes all for training, or the source's own
            split.
    """

    hold_out: HoldOut = None


class _PosedScene(Strict):
    """Photos with known cameras, in a world of any scale and, maybe, any tilt."""

    path: str
    max_image_px: int = Field(1600, ge=16)
    extent: float | None = Field(10.0, gt=0)
    up: Literal["estimated", "given"] = "estimated"
    place: Place | None = None
    normals: Axes = "opencv"

    @property
    def given_turn(self) -> NDArray[np.float64] | None:
        """No turn at all if the format's up, -y, is to be trusted; None to estimate it."""
        return np.eye(3) if self.up == "given" else None


class NerfOsrOriginalScene(_PosedScene):
    """A NeRF-OSR scene as its authors published it."""

    format: Literal["nerf-osr-original"]


class ColmapScene(_PosedScene, UnsplitScene):
    """A COLMAP folder: photos and a sparse model."""

    format: Literal["colmap"]


class NerfstudioScene(_PosedScene, UnsplitScene):
    """A nerfstudio folder: photos and transforms.json."""

    format: Literal["nerfstudio"]


class PhotosScene(UnsplitScene):
    """A folder of anybody's photos, or a video."""

    format: Literal["photos"]
    path: str
    max_image_px: int = Field(1600, ge=16)
    extent: float | None = Field(10.0, gt=0)
    matching: Literal["exhaustive", "sequential", "retrieval", "spatial"] | None = None
    video_frames: int = Field(100, ge=3)
    hold_out: HoldOut = 8
    place: Place | None = None
    normals: Axes = "opencv"


SceneSettings = Annotated[
    SyntheticScene
    | NerfOsrScene
    | NerfOsrOriginalScene
    | ColmapScene
    | NerfstudioScene
    | PhotosScene,
    Field(discriminator="format"),
]


def parse_scene(values: Mapping[str, Any], source: str) -> SceneSettings:
    """Validate what an entry of ``scenes`` says about its source.

    Raises:
        InputError: On the first unknown key, missing key or wrong value.
    """
    try:
        scene: SceneSettings = TypeAdapter(SceneSettings).validate_python(values)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{source}: scene entry, key '{key}': {first['msg']}") from None
    return scene
