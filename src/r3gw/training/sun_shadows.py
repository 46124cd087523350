"""Shadows of the sun while a run trains: kept for a while, because the scene changes slowly."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.lighting.sun import PointSun
from r3gw.model.model import SceneModel
from r3gw.rendering.compose import Sunlight
from r3gw.rendering.sun_shadow import SunShadow, shadow_in
from r3gw.training.schedule import Schedule

NEVER = -1
MOST_KEPT = 64  # maps of up to 2 MB: sessions have one each; where photos have, most are too old


@dataclass
class SunShadows:
    """The shadow maps of the lights of a run.

    Attributes:
        cast: By row of the appearance embedding: the iteration of which the map is, and the map.
    """

    cast: dict[int, tuple[int, SunShadow]] = field(default_factory=dict)

    def of(
        self, model: SceneModel, row: int, sun: PointSun, iteration: int, schedule: Schedule
    ) -> Sunlight:
        """A photo's sun and its shadows, cast anew if they are old.

        Args:
            model: The scene.
            row: Whose light it is.
            sun: The light's sun.
            iteration: Counts from 1.
            schedule: Says when shadows begin, and when they are old.
        """
        if iteration < schedule.occlusion_first:
            return Sunlight(sun.times(model.description.sharp), None)
        since, shadow = self.cast.get(row, (NEVER, None))
        if shadow is None or iteration - since >= schedule.shadow_age:
            shadow = shadow_in(model, sun.direction)
            self.cast[row] = (iteration, shadow)
            if len(self.cast) > MOST_KEPT:
                del self.cast[min(self.cast, key=lambda each: self.cast[each][0])]
        return Sunlight(sun.times(model.description.sharp), shadow)

    def tensors(self) -> dict[str, Tensor]:
        """What a checkpoint keeps of the maps as arrays, by name."""
        kept = {}
        for row, (_, shadow) in self.cast.items():
            kept[f"{row}.depth"], kept[f"{row}.alpha"] = shadow.depth, shadow.alpha
            kept[f"{row}.pose"] = shadow.camera.cam_from_world
        return kept

    def record(self) -> dict[str, list[float]]:
        """What a checkpoint keeps of the maps as numbers, by row."""
        return {
            str(row): [
                float(since),
                *shadow.camera.intrinsics,
                shadow.nearest,
                shadow.bias,
                shadow.softness,
            ]
            for row, (since, shadow) in self.cast.items()
        }

    @staticmethod
    def restored(
        tensors: Mapping[str, Tensor], record: Mapping[str, Sequence[float]]
    ) -> "SunShadows":
        """Invert `tensors` and `record`."""
        kept = SunShadows()
        for row, (since, fx, fy, cx, cy, *sizes) in record.items():
            depth, alpha = tensors[f"{row}.depth"], tensors[f"{row}.alpha"]
            height, width = depth.shape
            camera = Camera(tensors[f"{row}.pose"], (fx, fy, cx, cy), width, height)
            nearest, bias, softness = sizes
            shadow = SunShadow(camera, depth, alpha, nearest, bias, softness)
            kept.cast[int(row)] = (int(since), shadow)
        return kept
