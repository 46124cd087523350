"""Suns that date, time and place tell, up to how the scene lies to the north (beyond the paper).

That one angle, the scene's yaw, is first taken from how clear skies are graded in the photos. From
there suns are learned for a while, each by itself; then the yaw is taken that fits best what was
learned, whatever single suns went wrong. From then on the suns are tied together: only the yaw is
learned any more, by all photos.
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import cos, pi, radians, sin
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.rotations import rotation_about_axis
from r3gw.lighting.cie_sky import clear_sky
from r3gw.model.appearance import Appearance
from r3gw.model.light_models.daylight import Daylight
from r3gw.scene.sun_position import SunPosition
from r3gw.training.sun_from_sky import brightness_and_looks, spread
from r3gw.training.visible_sky import VisibleSky, cover_of

log = logging.getLogger(__name__)

YAWS = 360  # that are tried, a degree apart
MOST_SKIES = 24  # that the first yaw is taken from
MOST_COVER = 0.5  # of a sky that says where its sun stands
# A sun learned so far from where time puts it tells of a wrong clock: wrong suns of embedded
# scenes end up to 50 degrees off. It stays as it was learned.
FARTHEST_DEG = 60.0
STRONG = 0.5  # of the median sun: weaker ones, behind clouds, say nothing of a clock
SHARE = 0.2  # of what the photos' suns would move in a step, by which the yaw does
NO_SUN = -14.0  # logarithm of the power of a sun below the horizon

Direction = Float[Tensor, "3"]
Suns = Sequence[Direction | None]


def direction_of(position: SunPosition) -> Direction:
    """Unit vector to a sun in world axes, if north were +z and east +x."""
    elevation, azimuth = radians(position.elevation_deg), radians(position.azimuth_deg)
    level = cos(elevation)
    return torch.tensor([level * sin(azimuth), -sin(elevation), level * cos(azimuth)])


def suns_by_row(rows: Sequence[int], suns: Suns) -> list[Direction | None]:
    """Per row of the appearance embedding, the mean of its photos' suns; None if none is known.

    Args:
        rows: Of each photo.
        suns: Of each photo; photos at the end may be missing.
    """
    found: list[list[Direction]] = [[] for _ in range(max(rows) + 1)]
    for row, sun in zip(rows, suns, strict=False):
        if sun is not None:
            found[row].append(sun)
    return [
        torch.nn.functional.normalize(torch.stack(each).sum(dim=0), dim=0) if each else None
        for each in found
    ]


def turned(suns: Float[Tensor, "n 3"], yaw_deg: float) -> Float[Tensor, "n 3"]:
    """Suns in a scene whose +z lies so far west of north."""
    rotation = rotation_about_axis(1, radians(yaw_deg)).to(suns)
    return suns @ rotation.T


def yaw_by_skies(suns: Suns, seen: Sequence[Sequence[VisibleSky]]) -> float | None:
    """The yaw in degrees under which clear skies are graded as photos show; None without any.

    Args:
        suns: Per row of the embedding, as `direction_of` has them.
        seen: Per row, the skies that its photos show.
    """
    left = torch.zeros(YAWS)
    used = 0
    for sun, photos in zip(suns, seen, strict=True):
        if sun is None or is_night(sun) or not photos or used == MOST_SKIES:
            continue
        colour = torch.cat([photo.radiance for photo in photos]).median(dim=0).values
        if cover_of(colour) > MOST_COVER:
            continue
        shown, looks = brightness_and_looks(photos)
        whole = spread(shown).clamp_min(1e-6)
        for yaw in range(YAWS):
            there = turned(sun[None], yaw * 360 / YAWS)[0]
            left[yaw] += spread(shown - clear_sky(looks, there).sum(dim=0).log()) / whole
        used += 1
    return int(left.argmin()) * 360 / YAWS if used else None


def yaw_by_suns(
    known: Float[Tensor, "n 3"], learned: Float[Tensor, "n 3"], weights: Float[Tensor, "n"]
) -> float:
    """The yaw in degrees with the least weighted sum of angles between known and learned suns.

    A sum of angles, not of their squares, follows the many and not the few that went wrong.
    """
    sums = [
        (weights * angles_deg(turned(known, yaw * 360 / YAWS), learned)).sum()
        for yaw in range(YAWS)
    ]
    return int(torch.stack(sums).argmin()) * 360 / YAWS


def angles_deg(first: Float[Tensor, "n 3"], second: Float[Tensor, "n 3"]) -> Float[Tensor, "n"]:
    """Angles between unit vectors."""
    return torch.arccos((first * second).sum(dim=-1).clamp(-1.0, 1.0)) * (180 / pi)


def azimuths_deg(directions: Float[Tensor, "n 3"]) -> Float[Tensor, "n"]:
    """From +z towards +x, of vectors of any length."""
    return torch.atan2(directions[:, 0], directions[:, 2]) * (180 / pi)


def is_night(sun: Direction) -> bool:
    """Whether a sun stands below the horizon, or on it."""
    return float(-sun[1]) <= 0.0


@dataclass
class TiedSuns:
    """Suns that move together.

    Attributes:
        yaw_deg: From north to the scene's +z, as `turned` takes it; None until it is solved.
        known: By row of the embedding, where the suns stand if north were +z.
        nights: Rows whose sun is below the horizon: they have none.
        doubted: Rows whose sun was learned too far from where time puts it, and how far in degrees.
    """

    yaw_deg: float | None = None
    known: dict[int, Direction] = field(default_factory=dict)
    nights: list[int] = field(default_factory=list)
    doubted: dict[int, float] = field(default_factory=dict)

    @torch.no_grad()
    def keep(self, appearance: Appearance, suns: Suns, iteration: int, tied_from: int) -> None:
        """Put suns back to where time and yaw say, once they are tied; after every step.

        Args:
            appearance: Holds the light; changed in place. Of lights without a sun of their own
                nothing is kept.
            suns: Of each photo, as `direction_of` has them.
            iteration: Counts from 1.
            tied_from: Iteration at which the yaw is solved.
        """
        light = appearance.light_model
        if not isinstance(light, Daylight):
            return
        if iteration in (1, tied_from):
            by_row = suns_by_row(appearance.rows, suns)
            self.nights = [r for r, sun in enumerate(by_row) if sun is not None and is_night(sun)]
            if iteration == tied_from:
                self.solve(light, by_row)
        if self.nights:
            light.log_sun_powers[self.nights] = NO_SUN
        if self.yaw_deg is not None and self.known:
            self._move(light)

    @torch.no_grad()
    def solve(self, light: Daylight, suns: Suns) -> None:
        """Find the yaw from what a light learned, and tie all suns that are near it.

        Args:
            light: What was learned so far.
            suns: Per row, as `direction_of` has them.
        """
        rows = [row for row, sun in enumerate(suns) if sun is not None and not is_night(sun)]
        if not rows:
            return
        known = torch.stack([sun for row in rows if (sun := suns[row]) is not None])
        learned = torch.nn.functional.normalize(light.sun_directions[rows], dim=-1)
        power = light.log_sun_powers[rows].exp().mean(dim=-1)
        self.yaw_deg = yaw_by_suns(known, learned, _weights(light, rows, known))
        log.info("north lies %.0f degrees from +z towards +x", self.yaw_deg)
        off = angles_deg(turned(known, self.yaw_deg), learned)
        is_doubted = (off > FARTHEST_DEG) & (power >= STRONG * power.median())
        for number, row in enumerate(rows):
            if bool(is_doubted[number]):
                self.doubted[row] = round(float(off[number]), 1)
            else:
                self.known[row] = known[number]
        for row, angle in self.doubted.items():
            log.warning(
                "light %d: the sun was learned %.0f degrees from where date, time and place put "
                "it, so it stays as learned; is that photo's clock or time zone wrong?",
                row,
                angle,
            )

    @torch.no_grad()
    def _move(self, light: Daylight) -> None:
        """Let the yaw follow its suns, and the suns the yaw."""
        assert self.yaw_deg is not None  # the caller's condition
        rows, known = list(self.known), torch.stack(list(self.known.values()))
        there = turned(known, self.yaw_deg)
        weights = _weights(light, rows, known)
        moved = azimuths_deg(light.sun_directions[rows]) - azimuths_deg(there)
        moved = torch.remainder(moved + 180, 360) - 180
        self.yaw_deg += SHARE * float((weights * moved).sum() / weights.sum())
        light.sun_directions[rows] = turned(known, self.yaw_deg)

    def record(self) -> dict[str, Any]:
        """What a checkpoint and run.json say of it."""
        return {
            "yaw_deg": self.yaw_deg,
            "known": {str(row): sun.tolist() for row, sun in self.known.items()},
            "nights": self.nights,
            "doubted_deg": {str(row): off for row, off in self.doubted.items()},
        }

    @staticmethod
    def restored(record: Mapping[str, Any]) -> "TiedSuns":
        """Invert `record`."""
        return TiedSuns(
            record["yaw_deg"],
            {int(row): torch.tensor(sun) for row, sun in record["known"].items()},
            list(record["nights"]),
            {int(row): float(off) for row, off in record["doubted_deg"].items()},
        )


def _weights(
    light: Daylight, rows: Sequence[int], known: Float[Tensor, "n 3"]
) -> Float[Tensor, "n"]:
    """How much each sun says of the yaw.

    A weak sun was hardly learned, and a sun overhead says nothing. One that went wrong near a wall
    grows strong without an end, so that none counts for more than the median.
    """
    power = light.log_sun_powers[list(rows)].exp().mean(dim=-1)
    weights: Tensor = power.clamp(max=float(power.median())) * known[:, [0, 2]].norm(dim=-1)
    return weights
