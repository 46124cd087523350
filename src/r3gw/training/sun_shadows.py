"""Shadows of the sun while a run trains: kept for a while, because the scene changes slowly."""

from dataclasses import dataclass, field

from r3gw.lighting.sun import PointSun
from r3gw.model.model import SceneModel
from r3gw.rendering.compose import Sunlight
from r3gw.rendering.sun_shadow import SunShadow, shadow_in
from r3gw.training.schedule import Schedule

NEVER = -1


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
            return Sunlight(sun, None)
        since, shadow = self.cast.get(row, (NEVER, None))
        if shadow is None or iteration - since >= schedule.shadow_age:
            shadow = shadow_in(model, sun.direction)
            self.cast[row] = (iteration, shadow)
        return Sunlight(sun, shadow)
