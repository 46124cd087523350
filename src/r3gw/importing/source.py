"""What a format's reader hands to the writer: views and points in the source's own frame.

A new format is one reader that returns a `SourceScene`; scaling, gauge, copying and naming are
done once, in r3gw.importing.write.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from r3gw.geometry.cameras import Camera
from r3gw.importing.lens import Lens
from r3gw.scene import EvaluationEntry, GroundTruth
from r3gw.scene.sun_position import SunPosition

MaskKind = Literal["is_valid", "is_sky", "eval"]
Axes = Literal["opencv", "opengl", "world"]


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
class SourceNormals:
    """A normal map's file.

    Attributes:
        path: The picture.
        axes: That its vectors are given in (`r3gw.importing.normals`).
    """

    path: Path
    axes: Axes


@dataclass(frozen=True)
class SourcePoints:
    """Sparse points in the source's frame, which may lie millions of metres from its origin.

    Attributes:
        xyz: ``[N, 3]``, in double precision until the gauge has centred and scaled them.
        rgb: ``[N, 3]``, display values.
    """

    xyz: NDArray[np.float64]
    rgb: NDArray[np.uint8]


@dataclass(frozen=True)
class SourceView:
    """One photo before the import.

    Attributes:
        path: The photo's path below the folder of photos (r3gw.scene.names); its identity.
        photo: The picture, its pixels in the order in which they are stored.
        camera: Pinhole, in the source's frame, at full size.
        split: Whether the photo is trained on or held out.
        session: When the photo was taken, for photos that share a light.
        masks: Masks that came with the data, of the photo's size.
        labels: Picture of class colours or ids that came with the data, of the photo's size.
        evaluation: How a test view is lit and masked; paths are the source's.
        truth: Ground truth of the photo, if known; paths are the source's.
        lens: The photo's distorted camera; the writer undistorts photo and masks from it to
            ``camera``. None if ``camera`` describes the photo itself.
        exif: EXIF of the photo as it was taken, where ``photo`` has lost it; None: as in ``photo``.
        sun: Where the sun stood, if the data say so.
        normals: Normal map that came with the data, of the photo's size.
    """

    path: str
    photo: Path
    camera: Camera
    split: Literal["train", "test"]
    session: str | None = None
    masks: Mapping[MaskKind, SourceMask] = field(default_factory=dict)
    labels: Path | None = None
    evaluation: EvaluationEntry | None = None
    truth: GroundTruth | None = None
    lens: Lens | None = None
    exif: bytes | None = None
    sun: SunPosition | None = None
    normals: SourceNormals | None = None


@dataclass(frozen=True)
class SourceScene:
    """All that a reader found.

    Attributes:
        views: Photos with their cameras.
        points: Sparse points, one or more.
        turn: Rotation ``[3, 3]`` that makes up -y in the source's frame; None leaves it to the
            photos, from whose tilt up is estimated.
        left_out: Photos that are there but not in the scene, by path, and why.
        notes: What else the import decided, in whole sentences.
        facts: More for sfm_report.json.
    """

    views: tuple[SourceView, ...]
    points: SourcePoints
    turn: NDArray[np.float64] | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    facts: Mapping[str, object] = field(default_factory=dict)
