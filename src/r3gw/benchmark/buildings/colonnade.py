"""Colonnade: a museum front with a portico, pediment, polished floor and side wings."""

import numpy as np

from r3gw.benchmark import plants, textures
from r3gw.benchmark.lights import Session
from r3gw.benchmark.materials import Material
from r3gw.benchmark.meshes import Mesh, Part, box, join, moulding, place, polygon
from r3gw.benchmark.ornaments import (
    CORNICE,
    balustrade,
    column,
    gable_roof,
    lamp,
    pediment,
    steps,
    urn,
)
from r3gw.benchmark.place import Place, Walk, common_materials, facade, surroundings, turned_walls
from r3gw.benchmark.walls import Opening, door, surround, wall

FLOOR = 0.6  # Height of the portico's floor
COLUMN = 3.1
HALF = 3.3  # Half width of the portico
BACK = 1.9  # Depth of the portico
CELLA_HIGH = (3.1, 6.5)


def build(random: np.random.Generator) -> tuple[list[Part], dict[str, Material]]:
    """Parts and materials of the place."""
    parts = surroundings(random) + _portico() + _cella() + _wings() + _square(random)
    sand = (0.6, 0.53, 0.42)
    own = {
        "stone": Material(
            textures.blocks(
                random, sand, 8, 3, joint=(0.45, 0.4, 0.32), joint_px=3, variation=0.06
            ),
            4.0,
            roughness=0.65,
        ),
        "trim": Material(textures.plaster(random, (0.64, 0.59, 0.5), 0.05), 3.0, roughness=0.55),
        "frieze": Material(textures.plaster(random, (0.55, 0.47, 0.36), 0.05), 3.0, roughness=0.6),
        "marble": Material(
            textures.marble(random, (0.42, 0.38, 0.34), (0.22, 0.16, 0.13)), 2.0, roughness=0.3
        ),
        "wing": Material(textures.plaster(random, (0.58, 0.36, 0.2), 0.06), 3.0, roughness=0.8),
        "copper": Material(
            textures.blocks(
                random,
                (0.16, 0.27, 0.23),
                3,
                10,
                joint=(0.1, 0.17, 0.15),
                variation=0.06,
                shift=0.0,
            ),
            4.0,
            roughness=0.45,
        ),
        "door": Material(textures.planks(random, (0.06, 0.1, 0.075), 10), 1.2, roughness=0.35),
    }
    return parts, common_materials(random) | own


def _portico() -> list[Part]:
    """Steps, floor, six columns in front and two behind, entablature with triglyphs, pediment."""
    flight = steps((-HALF - 0.15, -0.35), (HALF + 0.15, BACK), 4, FLOOR / 4, 0.26)
    floor = [(-HALF - 0.1, -0.3), (HALF + 0.1, -0.3), (HALF + 0.1, BACK), (-HALF - 0.1, BACK)]
    shaft = column(COLUMN, 0.24, 22)
    feet = [(x, 0.0) for x in np.linspace(-HALF + 0.3, HALF - 0.3, 6)]
    feet += [(-HALF + 0.3, 1.15), (HALF - 0.3, 1.15)]
    columns = join([shaft.placed(0.0, (x, y, FLOOR)) for x, y in feet])
    z = FLOOR + COLUMN
    low, high = (-HALF, -0.28), (HALF, BACK)
    architrave = moulding(low, high, [(0, z), (0, z + 0.16), (0.03, z + 0.17), (0.03, z + 0.3)])
    frieze = moulding(low, high, [(0.0, z + 0.3), (0.0, z + 0.72)])
    cornice = moulding(low, high, CORNICE).placed(0.0, (0, 0, z + 0.72))
    gable = pediment(2 * HALF + 0.3, 1.25, BACK + 0.3).placed(0.0, (-HALF - 0.15, -0.3, z + 1.0))
    return [
        ("trim", flight),
        ("marble", polygon([(x, y, FLOOR + 0.012) for x, y in floor])),
        ("trim", columns),
        ("trim", join([architrave, cornice, gable])),
        ("frieze", frieze),
        ("trim", _triglyphs(z + 0.3)),
        ("frieze", _reliefs(z + 1.0)),
    ]


def _triglyphs(z: float) -> Mesh:
    """Groups of three upright bars along the frieze."""
    bars = []
    for x in np.linspace(-HALF + 0.15, HALF - 0.15, 12):
        for shift in (-0.09, 0.0, 0.09):
            bars.append(box((x + shift - 0.03, -0.34, z), (x + shift + 0.03, -0.28, z + 0.42)))
        bars.append(box((x - 0.14, -0.345, z - 0.06), (x + 0.14, -0.28, z)))
    return join(bars)


def _reliefs(z: float) -> Mesh:
    """A shield with laurels on the gable."""
    pieces = [box((-0.32, -0.36, z + 0.2), (0.32, -0.28, z + 0.8))]
    pieces.append(box((-0.22, -0.4, z + 0.3), (0.22, -0.3, z + 0.7)))
    for i in range(5):
        x, height = 0.5 + 0.3 * i, 0.5 - 0.08 * i
        for side in (-1, 1):
            low, high = sorted((side * x, side * (x + 0.2)))
            pieces.append(box((low, -0.34, z + 0.18), (high, -0.28, z + 0.18 + height)))
    return join(pieces)


def _cella() -> list[Part]:
    """The hall behind the columns, with a tall door, niches and a copper roof."""
    width = 2 * CELLA_HIGH[0]
    entry = Opening(width / 2 - 0.65, width / 2 + 0.65, FLOOR, FLOOR + 2.3, False, 0.3)
    lights = [
        Opening(width / 2 + x - 0.36, width / 2 + x + 0.36, FLOOR + 0.7, FLOOR + 2.2, False, 0.22)
        for x in (-1.95, 1.95)
    ]
    front = facade(width, FLOOR + COLUMN, lights, "stone", (2, 3))[1:]
    front = [("stone", wall(width, FLOOR + COLUMN, [entry, *lights])), *front, *door(entry)]
    front += [("trim", surround(o, 0.14, 0.06)) for o in (entry, *lights)]
    for o in (entry, *lights):
        hood = box((o.left - 0.25, -0.2, o.top + 0.2), (o.right + 0.25, 0, o.top + 0.3))
        front.append(("trim", hood))
    depth = CELLA_HIGH[1] - BACK
    tall = FLOOR + COLUMN + 0.72
    side_lights = [Opening(y - 0.4, y + 0.4, 1.5, 3.2, True, 0.25) for y in (0.9, 2.3, 3.7)]
    side = facade(depth, tall, side_lights, "stone", (2, 4))
    side += [("trim", surround(o, 0.12, 0.05)) for o in side_lights]
    for y in (0.12, 1.6, 3.0, 4.48):
        pilaster = box((y - 0.13, -0.09, 0), (y + 0.13, 0, tall))
        side.append(("trim", pilaster))
    low, high = (-CELLA_HIGH[0], BACK), CELLA_HIGH
    back = [("stone", wall(width, tall, []))]
    parts = turned_walls(low, high, {"front": front, "right": side, "left": side, "back": back})
    roof = gable_roof((-HALF, 0.0), (HALF, CELLA_HIGH[1]), 1.22, 0.12, 9)
    base = [(0.08, 0.0), (0.08, FLOOR - 0.1), (0.0, FLOOR)]
    return [
        *parts,
        ("trim", moulding(low, high, base)),
        ("trim", moulding(low, high, CORNICE).placed(0.0, (0, 0, tall))),
        ("copper", roof.placed(0.0, (0, 0, tall + 0.3))),
    ]


def _wings() -> list[Part]:
    """Lower wings on both sides, ochre render with stone windows and a balustrade on top."""
    parts: list[Part] = []
    width, height = 3.0, 2.9
    openings = [Opening(x - 0.36, x + 0.36, 0.9, 2.2, True, 0.2) for x in (0.8, 2.2)]
    front = facade(width, height, openings, "wing", (2, 3))
    front += [("trim", surround(o, 0.12, 0.06)) for o in openings]
    for x in (0.1, 1.5, 2.9):
        front.append(("trim", box((x - 0.12, -0.07, 0.4), (x + 0.12, 0, height))))
    side = facade(3.2, height, [Opening(1.2, 2.0, 0.9, 2.2, True, 0.2)], "wing", (2, 3))
    for low_x in (-CELLA_HIGH[0] - width, CELLA_HIGH[0]):
        low, high = (low_x, 2.6), (low_x + width, 5.8)
        parts += turned_walls(low, high, {"front": front, "left": side, "right": side})
        parts.append(("trim", moulding(low, high, [(0.07, 0.0), (0.07, 0.36), (0.0, 0.42)])))
        parts.append(("trim", moulding(low, high, CORNICE).placed(0.0, (0, 0, height))))
        parts.append(("trim", balustrade(width).placed(0.0, (low_x, 2.7, height + 0.24))))
    return parts


def _square(random: np.random.Generator) -> list[Part]:
    """A paved square with lawns, hedges, urns, lamps and trees."""
    paved = [(-7.5, -9.5, 0.01), (7.5, -9.5, 0.01), (7.5, 2.6, 0.01), (-7.5, 2.6, 0.01)]
    parts: list[Part] = [("paving", polygon(paved))]
    for x0 in (-6.6, 2.6):
        parts.append(("kerb", box((x0 - 0.1, -5.6, 0), (x0 + 4.1, -2.3, 0.1))))
        parts.append(("lawn", box((x0, -5.5, 0.0), (x0 + 4.0, -2.4, 0.12))))
        parts += place(plants.tufts(random, (0, 0), (4.0, 3.1), 900), 0, (x0, -5.5, 0.1))
        parts += plants.hedge(random, (x0 + 0.2, -2.75, 0.1), (x0 + 3.8, -2.45, 0.55), 750.0)
    for x in (-3.95, 3.95):
        shape = [(0.06, 0), (0.06, 0.1), (0, 0.16), (0, 0.7), (0.06, 0.76), (0.06, 0.84)]
        pedestal = moulding((x - 0.3, -0.9), (x + 0.3, -0.3), shape)
        parts += [("trim", pedestal), ("trim", urn(1.0).placed(0.0, (x, -0.6, 0.84)))]
    for x, y in ((-2.3, -3.2), (2.3, -3.2)):
        parts += place(lamp(2.1), 0, (x, y, 0))
    for x, y, height in ((-8.6, 0.6, 4.4), (-8.9, 4.6, 5.2), (8.8, 0.2, 4.8), (9.2, 5.0, 4.6)):
        parts += place(plants.tree(random, height, 0.44 * height), 0, (x, y, 0))
    for x in (-4.6, -5.4, 4.7, 5.6):
        parts += place(plants.bush(random, 0.42, 0.7), 0, (x, 2.0, 0))
    return parts


PLACE = Place(
    "colonnade",
    (
        Session("03-03_10_20", 135.0, 28.0, 3.0, 0.0, 0.2),
        Session("03-03_16_40", 243.0, 16.0, 3.6, 0.0, 0.3),
        Session("11-06_12_50", 187.0, 61.0, 2.4, 0.0, 0.35),
        Session("19-07_19_00", 268.0, 17.0, 3.0, 0.05, 0.45),
        Session("28-09_14_10", 205.0, 40.0, 7.0, 0.55, 0.4),
        Session("15-12_11_30", 166.0, 20.0, 3.0, 1.0, 0.2),
        Session("23-05_09_00", 112.0, 36.0, 2.6, 0.0, 0.3, True),
        Session("23-05_15_40", 226.0, 45.0, 3.2, 0.0, 0.15, True),
        Session("07-10_11_10", 158.0, 33.0, 5.0, 0.3, 0.5, True),
        Session("12-01_13_20", 192.0, 24.0, 4.0, 0.85, 0.3, True),
    ),
    Walk((0.0, 1.2, 2.8), 9.6, 11.6, 48.0, 1.15, (0.74, 1.0)),
    build,
)
