"""A sparse model with known cameras, as plain values: what readers and reconstruction both give."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.importing.lens import Lens
from r3gw.importing.posed import MOST_UNITS
from r3gw.importing.source import SourcePoints


@dataclass(frozen=True)
class PosedModel:
    """What a model holds.

    Attributes:
        cameras: Pinhole cameras by image name, as written in the model.
        lenses: The distorted camera of every image that has one.
        points: The sparse points; there may be none.
    """

    cameras: Mapping[str, Camera]
    lenses: Mapping[str, Lens]
    points: SourcePoints

    def require_usable(self, source: Path) -> None:
        """Refuse a model without images, or with points that are nowhere.

        Raises:
            InputError: Naming ``source``.
        """
        if not self.cameras:
            raise InputError(f"{source}: the model has no images with a pose; run SfM again")
        if not (np.abs(self.points.xyz) <= MOST_UNITS).all():
            raise InputError(f"{source}: the model has points at NaN or infinity; run SfM again")

    def require_pinhole(self, source: Path) -> None:
        """Refuse distorted cameras.

        Raises:
            InputError: Naming an image, its camera's model and the remedy.
        """
        if self.lenses:
            name, lens = next(iter(self.lenses.items()))
            raise InputError(
                f"{source}: camera of {name} has the model {lens.model}, but photos must be "
                "undistorted to PINHOLE; run COLMAP's image_undistorter, or import the folder as "
                "'colmap', which undistorts"
            )
