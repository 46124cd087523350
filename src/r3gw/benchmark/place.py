"""A place: a building on its ground among plants and neighbours, its light and where visitors walk.

Building axes (r3gw.benchmark.meshes) turn into world axes by ``world = (x, -z, y)``: the street is
towards -z, and up is -y.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from r3gw.benchmark import plants, textures
from r3gw.benchmark.lights import Session
from r3gw.benchmark.materials import Kind, Material
from r3gw.benchmark.meshes import Number, Part, Vector, box, place, polygon
from r3gw.benchmark.ornaments import gable_roof
from r3gw.benchmark.walls import Opening, wall, window

GROUND_EDGE = 70.0
BACKDROP_RADIUS = 21.0


@dataclass(frozen=True)
class Walk:
    """Where photos are taken: an arc around the building, in building axes.

    Attributes:
        focus: Point that photos look at.
        near, far: Distance range from the focus, level.
        arc_deg: Half width of the arc about straight-on.
        eye: Height of the camera above the ground.
        focal: Range of focal lengths, in picture widths.
    """

    focus: tuple[float, float, float]
    near: float
    far: float
    arc_deg: float
    eye: float
    focal: tuple[float, float]


@dataclass(frozen=True)
class Place:
    """One benchmark scene.

    Attributes:
        name: Its name in `r3gw.benchmark.generate.SCENES`.
        sessions: Its light list, training sessions first.
        walk: Where photos are taken.
        build: Makes parts and materials from a random stream.
    """

    name: str
    sessions: tuple[Session, ...]
    walk: Walk
    build: Callable[[np.random.Generator], tuple[list[Part], dict[str, Material]]]


def common_materials(random: np.random.Generator) -> dict[str, Material]:
    """Ground, plants, glass, metal and the backdrop; buildings add or replace theirs."""
    green, ground, far = Kind.VEGETATION, Kind.GROUND, Kind.BACKDROP
    stone = (0.34, 0.32, 0.29)
    return {
        "lawn": Material(
            textures.speckle(random, (0.045, 0.075, 0.02), (0.14, 0.17, 0.06), 0.5), 5.0, kind=green
        ),
        "grass": Material(
            textures.speckle(random, (0.06, 0.1, 0.025), (0.15, 0.19, 0.06), 0.3), 1.0, kind=green
        ),
        "leaves": Material(
            textures.speckle(random, (0.035, 0.075, 0.015), (0.13, 0.18, 0.045), 0.2), kind=green
        ),
        "needles": Material(
            textures.speckle(random, (0.02, 0.045, 0.018), (0.07, 0.1, 0.04), 0.2), kind=green
        ),
        "bark": Material(
            textures.speckle(random, (0.06, 0.045, 0.03), (0.16, 0.13, 0.1)), 0.8, kind=green
        ),
        "paving": Material(
            textures.blocks(random, stone, 6, 4, joint=(0.15, 0.14, 0.12), variation=0.13),
            4.0,
            roughness=0.6,
            kind=ground,
        ),
        "gravel": Material(
            textures.speckle(random, (0.24, 0.21, 0.17), (0.42, 0.38, 0.32), 0.25), 2.5, kind=ground
        ),
        "kerb": Material((0.36, 0.35, 0.33), roughness=0.7, kind=ground),
        "glass": Material((0.025, 0.03, 0.035), roughness=0.22, specular=1.0),
        "frame": Material((0.62, 0.61, 0.57), roughness=0.4),
        "metal": Material((0.035, 0.04, 0.04), roughness=0.35),
        "far_leaves": Material(
            textures.speckle(random, (0.03, 0.06, 0.02), (0.11, 0.15, 0.055), 0.2), kind=far
        ),
        "far_wall": Material(textures.plaster(random, (0.5, 0.45, 0.36)), 6.0, kind=far),
        "far_roof": Material((0.26, 0.13, 0.09), kind=far),
        "far_glass": Material((0.04, 0.045, 0.05), kind=far),
    }


def surroundings(random: np.random.Generator) -> list[Part]:
    """Lawn to the horizon, a belt of trees and a few houses behind the building."""
    edge = GROUND_EDGE
    parts = [
        ("lawn", polygon([(-edge, -edge, 0), (edge, -edge, 0), (edge, edge, 0), (-edge, edge, 0)]))
    ]
    turns = np.arange(0.0, 360.0, 8.0) + random.uniform(-2.5, 2.5, 45)
    for turn in np.radians(turns):
        reach = BACKDROP_RADIUS + random.uniform(0.0, 6.0)
        height = random.uniform(1.6, 3.4)
        centre = (reach * np.cos(turn), 3.0 + reach * np.sin(turn), 0.45 * height)
        points = plants.cloud(random, centre, (1.9, 1.9, 0.62 * height), 260)
        points[:, 2] = np.abs(points[:, 2])
        parts.append(("far_leaves", plants.leaves(random, points, 0.5)))
    for turn in (28.0, 62.0, 97.0, 131.0, 158.0):
        reach = BACKDROP_RADIUS + random.uniform(-2.0, 3.0)
        spot = (reach * np.cos(np.radians(turn)), 3.0 + reach * np.sin(np.radians(turn)), 0.0)
        parts += place(_house(random), turn - 90.0 + random.uniform(-15, 15), spot)
    return parts


def _house(random: np.random.Generator) -> list[Part]:
    """A plain neighbour, its front towards -y."""
    width, depth, height = random.uniform(3.0, 5.0), 3.0, random.uniform(1.6, 2.6)
    half = width / 2
    panes = [
        box((x - 0.18, -0.02, z), (x + 0.18, 0.1, z + 0.55))
        for x in np.linspace(-half + 0.6, half - 0.6, 4)
        for z in np.arange(0.5, height - 0.5, 1.0)
    ]
    roof = gable_roof((-half, 0.0), (half, depth), 1.1, 0.15, 4)
    return [
        ("far_wall", box((-half, 0, 0), (half, depth, height))),
        *(("far_glass", pane) for pane in panes),
        ("far_roof", roof.placed(0.0, (0, 0, height))),
    ]


def facade(
    width: Number,
    height: Number,
    openings: list[Opening],
    material: str,
    panes: tuple[int, int] = (2, 3),
) -> list[Part]:
    """A wall with a window in every opening, in wall coordinates."""
    parts = [(material, wall(width, height, openings))]
    for opening in openings:
        parts += window(opening, *panes)
    return parts


def turned_walls(low: Vector, high: Vector, sides: dict[str, list[Part]]) -> list[Part]:
    """Put wall-coordinate parts on the sides ``front right back left`` of a rectangle."""
    (x0, y0), (x1, y1) = low, high
    spots = {
        "front": (0.0, (x0, y0, 0.0)),
        "right": (90.0, (x1, y0, 0.0)),
        "back": (180.0, (x1, y1, 0.0)),
        "left": (270.0, (x0, y1, 0.0)),
    }
    return [part for side, parts in sides.items() for part in place(parts, *spots[side])]
