"""What is seen behind a scene: a sky learned for a photo, or an environment map."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from math import pi

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.spherical import angles_from_direction
from r3gw.imaging.colour import linear_from_display
from r3gw.lighting import sh
from r3gw.lighting.sh_rotation import rotate


class Sky(ABC):
    """Anything that has a colour in every direction."""

    @abstractmethod
    def radiance(self, directions: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch 3"]:
        """Linear radiance from unit world directions."""

    @abstractmethod
    def rotated(self, rotation: Float[Tensor, "3 3"]) -> "Sky":
        """The sky that shows in ``rotation @ d`` what this one shows in ``d``."""

    @abstractmethod
    def times(self, factor: float) -> "Sky":
        """The sky with its linear radiance multiplied."""


@dataclass(frozen=True, eq=False)
class LearnedSky(Sky):
    """A sky of few SH coefficients, as training learns it for every photo (paper, Eq. 11).

    Attributes:
        coefficients: SH of the display colour less 0.5.
        exposure: Factor on the linear colour.
    """

    coefficients: Float[Tensor, "skycoeff 3"]
    exposure: float = 1.0

    def radiance(self, directions: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch 3"]:
        """Linear radiance from unit world directions."""
        display = (sh.radiance(self.coefficients, directions) + 0.5).clamp(0.0, 1.0)
        return self.exposure * linear_from_display(display)

    def rotated(self, rotation: Float[Tensor, "3 3"]) -> "LearnedSky":
        """The sky that shows in ``rotation @ d`` what this one shows in ``d``."""
        return replace(self, coefficients=rotate(self.coefficients, rotation))

    def times(self, factor: float) -> "LearnedSky":
        """The sky with its linear radiance multiplied."""
        return replace(self, exposure=self.exposure * factor)


@dataclass(frozen=True, eq=False)
class MapSky(Sky):
    """An environment map (r3gw.lighting.envmap) as it hangs around the scene.

    Attributes:
        pixels: Linear radiance.
        exposure: Factor on the radiance.
        world_from_map: Rotation, float64.
    """

    pixels: Float[Tensor, "h w 3"]
    exposure: float = 1.0
    world_from_map: Float[Tensor, "3 3"] = field(
        default_factory=lambda: torch.eye(3, dtype=torch.float64)
    )
    # The map with one column more on either side, from the other: interpolation goes around.
    _padded: Float[Tensor, "1 3 h w2"] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        columns = torch.cat([self.pixels[:, -1:], self.pixels, self.pixels[:, :1]], dim=1)
        object.__setattr__(self, "_padded", columns.permute(2, 0, 1)[None].contiguous())

    def radiance(self, directions: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch 3"]:
        """Linear radiance from unit world directions, bilinear."""
        height, width = self.pixels.shape[:2]
        looks = directions.reshape(1, -1, 3) @ self.world_from_map.to(directions)
        theta, phi = angles_from_direction(looks)
        row = theta / pi * height - 0.5
        turn = torch.remainder(phi / (2 * pi) + 0.5, 1.0)
        column = turn * width + 0.5  # counted in the padded map
        grid = torch.stack([2 * column / (width + 1) - 1, 2 * row / (height - 1) - 1], dim=-1)
        values = torch.nn.functional.grid_sample(
            self._padded, grid[None], padding_mode="border", align_corners=True
        )
        return self.exposure * values[0, :, 0].T.reshape(directions.shape)

    def rotated(self, rotation: Float[Tensor, "3 3"]) -> "MapSky":
        """The sky that shows in ``rotation @ d`` what this one shows in ``d``."""
        return replace(self, world_from_map=rotation.double() @ self.world_from_map)

    def times(self, factor: float) -> "MapSky":
        """The map with its radiance multiplied."""
        return replace(self, exposure=self.exposure * factor)
