"""What a format's reader hands to the writer: views and points in the source's own frame.

A new format is one reader that returns a `SourceScene`; scaling, gauge, copying and naming are
done once, in r3gw.importing.write.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import pycolmap

from r3gw.geometry.cameras import Camera
from r3gw.scene import EvaluationEntry, GroundTruth, Points

MaskKind = Literal["is_valid", "is_sky", "eval"]


@dataclass(frozen=True)
class SourceMask:
    """A mask file.

    Attributes:
        path: The picture.
        white_means: The value that white stands for.
        levels: What the values of the user's own file were, if ``path`` was made from it.
    """

    path: Path
    white_means: bool = True
    levels: str | None = None


@dataclass(frozen=True)
class SourceView:
    """One photo before the import.

    Attributes:
        name: Stem of the photo.
        photo: The picture, its pixels in the order in which they are stored.
        camera: Pinhole, in the source's frame, at full size.
        lens: The photo's distorted camera; the writer undistorts photo and masks from it to
            ``camera``. None if ``camera`` describes the photo itself.
        masks: Masks that came with the data, of the photo's size.
        labels: Picture of class colours or ids that came with the data, of the photo's size.
        evaluation, truth: As in the scene, but with paths of the source.
    """

    name: str
    photo: Path
    camera: Camera
    split: Literal["train", "test"]
    session: str | None = None
    masks: Mapping[MaskKind, SourceMask] = field(default_factory=dict)
    labels: Path | None = None
    evaluation: EvaluationEntry | None = None
    truth: GroundTruth | None = None
    lens: pycolmap.Camera | None = None


@dataclass(frozen=True)
class SourceScene:
    """All views and points that a reader found."""

    views: tuple[SourceView, ...]
    points: Points
