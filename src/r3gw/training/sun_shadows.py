"""Shadows of the sun while a run trains: kept for a while, because the scene changes slowly.

What is kept is the shadow map of each sun, and how much of it reaches each Gaussian in each photo.
A photo comes again many times while the Gaussians stay the same and hardly move.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import cos, radians
from typing import Any

import torch
from jaxtyping import Float, UInt8
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.lighting.sun import PointSun
from r3gw.model.model import SceneModel
from r3gw.rendering.compose import Sunlight
from r3gw.rendering.sun_shadow import SunShadow, reach_in, shadow_in
from r3gw.training.schedule import Schedule

NEVER = -1
MOST_KEPT = 64  # maps of up to 2 MB: sessions have one each; where photos have, most are too old
# A sun that moves on while its shadows stay goes astray: nothing says that they fall elsewhere.
FAR_DEG = 1.0
STEPS = 255  # in which the share of the sun that reaches a Gaussian is kept


@dataclass(frozen=True, eq=False)
class Reached:
    """How much of a photo's sun reaches each Gaussian.

    Attributes:
        since: The iteration of which it is.
        sun: Unit vector to where the sun stood then.
        shares: Of the foreground, in `STEPS`.
    """

    since: int
    sun: Float[Tensor, "3"]
    shares: UInt8[Tensor, "f"]

    def has_moved(self, sun: PointSun) -> bool:
        """Whether the sun has gone so far that its shadows fall elsewhere."""
        return float((self.sun * sun.direction.detach()).sum()) < cos(radians(FAR_DEG))


@dataclass
class SunShadows:
    """The shadows of the suns of a run.

    Attributes:
        cast: By row of the appearance embedding: the iteration of which the map is, and the map.
        reached: By photo.
    """

    cast: dict[int, tuple[int, SunShadow]] = field(default_factory=dict)
    reached: dict[int, Reached] = field(default_factory=dict)

    def of(
        self,
        model: SceneModel,
        photo: int,
        camera: Camera,
        sun: PointSun,
        iteration: int,
        schedule: Schedule,
    ) -> Sunlight:
        """A photo's sun and its shadows, anew if they are old.

        Args:
            model: The scene.
            photo: Which training photo.
            camera: Its camera.
            sun: The sun of its light.
            iteration: Counts from 1.
            schedule: Says when shadows begin, and when they are old.
        """
        sharp = sun.times(model.description.sharp)
        if iteration < schedule.occlusion_first:
            return Sunlight(sharp, None)
        kept = self.reached.get(photo)
        if kept is None or iteration - kept.since >= schedule.reach_age or kept.has_moved(sun):
            row = model.appearance.rows[photo]
            shadow = self._shadow(model, row, sun, iteration, schedule)
            shares = (STEPS * reach_in(model, camera, shadow)).round().to(torch.uint8)
            kept = self.reached[photo] = Reached(iteration, sun.direction.detach().clone(), shares)
        return Sunlight(sharp, kept.shares.float() / STEPS)

    def forget_reached(self) -> None:
        """What reaches which Gaussian is unknown where Gaussians have come or gone."""
        self.reached.clear()

    def _shadow(
        self, model: SceneModel, row: int, sun: PointSun, iteration: int, schedule: Schedule
    ) -> SunShadow:
        """The shadow map of a row's sun, cast anew if it is old."""
        since, shadow = self.cast.get(row, (NEVER, None))
        if shadow is None or iteration - since >= schedule.shadow_age:
            shadow = shadow_in(model, sun.direction)
            self.cast[row] = (iteration, shadow)
            if len(self.cast) > MOST_KEPT:
                del self.cast[min(self.cast, key=lambda each: self.cast[each][0])]
        return shadow

    def tensors(self) -> dict[str, Tensor]:
        """What a checkpoint keeps as arrays, by name."""
        kept = {}
        for photo, reached in self.reached.items():
            kept[f"reached.{photo}.sun"] = reached.sun
            kept[f"reached.{photo}.shares"] = reached.shares
        for row, (_, shadow) in self.cast.items():
            kept[f"{row}.depth"], kept[f"{row}.alpha"] = shadow.depth, shadow.alpha
            kept[f"{row}.pose"] = shadow.camera.cam_from_world
        return kept

    def record(self) -> dict[str, dict[str, Any]]:
        """What a checkpoint keeps as numbers: of maps by row, of what reaches by photo."""
        maps = {
            str(row): [
                float(since),
                *shadow.camera.intrinsics,
                shadow.nearest,
                shadow.bias,
                shadow.softness,
            ]
            for row, (since, shadow) in self.cast.items()
        }
        return {
            "maps": maps,
            "reached": {str(photo): reached.since for photo, reached in self.reached.items()},
        }

    @staticmethod
    def restored(
        tensors: Mapping[str, Tensor], record: Mapping[str, Mapping[str, Any]]
    ) -> "SunShadows":
        """Invert `tensors` and `record`."""
        kept = SunShadows()
        for row, (since, fx, fy, cx, cy, *sizes) in record["maps"].items():
            depth, alpha = tensors[f"{row}.depth"], tensors[f"{row}.alpha"]
            height, width = depth.shape
            camera = Camera(tensors[f"{row}.pose"], (fx, fy, cx, cy), width, height)
            nearest, bias, softness = sizes
            shadow = SunShadow(camera, depth, alpha, nearest, bias, softness)
            kept.cast[int(row)] = (int(since), shadow)
        for photo, since in record["reached"].items():
            sun, shares = (tensors[f"reached.{photo}.{part}"] for part in ("sun", "shares"))
            kept.reached[int(photo)] = Reached(int(since), sun, shares)
        return kept
