"""Photos as witnesses of what is dark.

Where few photos look, training paints leaves before the sky and other dark things with the black
behind its Gaussians, and nothing in the Gaussians tells such a hole from a place that no photo saw.
A photo does: if it looked past the foreground at a point of the sky's dome, and the point is
uncovered, then it is dark as seen from there. From elsewhere that says little, because the dark
thing stood before the dome; so photos speak for cameras near their own alone.
"""

from collections.abc import Sequence
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import Camera, pixel_directions
from r3gw.relight.gaussians import Relightable

MAP_PX = 128  # Each photo's map is a square of this size, whatever the photo's shape.
MAP_LEVELS = 255  # Maps are rounded to bytes, as the page has them.
CLEAR_FROM = 0.1  # Share of foreground-free view from which a photo has seen what is behind.
REACH = 0.1  # How far a photo speaks, in distances from it to the middle of the surfaces.
MOST_NEAR = 4
SMALLEST_WEIGHT = 0.01


class Near(NamedTuple):
    """A photo that speaks for a camera, and how surely (0 to 1)."""

    number: int
    weight: float


class Witnesses:
    """The training photos of a scene; their maps are drawn when they are first asked for."""

    def __init__(self, gaussians: Relightable, cameras: Sequence[Camera]) -> None:
        """Witnesses of a scene.

        Args:
            gaussians: What was trained.
            cameras: Cameras of the photos that it was trained on.
        """
        self._gaussians = gaussians
        self._cameras = tuple(cameras) if gaussians.num_foreground else ()
        self._maps: dict[int, Float[Tensor, "map map"]] = {}
        self._last: tuple[Camera, Float[Tensor, "h w 1"]] | None = None

    def reaches(self) -> list[float]:
        """How far each photo speaks, in world units."""
        if not self._cameras:
            return []
        middle = self._gaussians.middle
        return [REACH * float((camera.centre - middle).norm()) for camera in self._cameras]

    def near(self, camera: Camera) -> list[Near]:
        """The photos that speak for a camera, the surest first, at most `MOST_NEAR`."""
        found = []
        for number, (photo, reach) in enumerate(zip(self._cameras, self.reaches(), strict=True)):
            distance = float((photo.centre - camera.centre).norm())
            weight = max(0.0, 1.0 - (distance / max(reach, 1e-12)) ** 2) ** 2
            if weight >= SMALLEST_WEIGHT:
                found.append(Near(number, weight))
        return sorted(found, key=lambda near: -near.weight)[:MOST_NEAR]

    def map_of(self, number: int) -> Float[Tensor, "map map"]:
        """How surely a photo saw past the foreground: 0 to 1, in `MAP_LEVELS` steps."""
        if number not in self._maps:
            seen = self._drawn(self._cameras[number].scaled(MAP_PX, MAP_PX))
            self._maps[number] = (seen * MAP_LEVELS).round() / MAP_LEVELS
        return self._maps[number]

    def darkness(self, camera: Camera) -> Float[Tensor, "h w 1"]:
        """How surely photos saw what is behind each pixel, so that uncovered is dark: 0 to 1."""
        if self._last is None or self._last[0] is not camera:
            self._last = (camera, self._darkness(camera))
        return self._last[1]

    @torch.no_grad()
    def _drawn(self, camera: Camera) -> Float[Tensor, "h w"]:
        gaussians = self._gaussians
        is_foreground = torch.zeros(len(gaussians.means), 1)
        is_foreground[: gaussians.num_foreground] = 1.0
        foreground = gaussians.drawn(is_foreground, camera).planes[0]
        return ((1.0 - foreground) / CLEAR_FROM).clamp(0.0, 1.0)

    def _darkness(self, camera: Camera) -> Float[Tensor, "h w 1"]:
        surest = torch.zeros(camera.height, camera.width)
        nearby = self.near(camera)
        if not nearby:
            return surest[..., None]
        directions, dome = pixel_directions(camera), self._gaussians.dome
        ends = None if dome is None else dome.exits(camera.centre, directions)
        for number, weight in nearby:
            pose = self._cameras[number].cam_from_world.float()
            # Without a dome, or from outside of it, what is behind is infinitely far away.
            local = (directions if ends is None else ends) @ pose[:3, :3].T
            if ends is not None:
                local = local + pose[:3, 3]
            surest = torch.maximum(surest, weight * self._looked_up(number, local))
        return surest[..., None]

    def _looked_up(self, number: int, local: Float[Tensor, "h w 3"]) -> Float[Tensor, "h w"]:
        """A photo's map where it sees points of its own camera frame; 0 outside of the photo."""
        photo = self._cameras[number]
        fx, fy, cx, cy = photo.intrinsics
        depth = local[..., 2].clamp_min(1e-6)
        right = (fx * local[..., 0] / depth + cx) / photo.width * 2 - 1
        down = (fy * local[..., 1] / depth + cy) / photo.height * 2 - 1
        is_inside = (local[..., 2] > 0) & (right.abs() <= 1) & (down.abs() <= 1)
        at = torch.stack([right, down], dim=-1)[None]
        found = torch.nn.functional.grid_sample(
            self.map_of(number)[None, None], at, padding_mode="border", align_corners=False
        )[0, 0]
        return torch.where(is_inside, found, 0.0)
