"""Townhouse: a baroque brick front of three storeys, rusticated below, with a lower neighbour."""

import numpy as np

from r3gw.benchmark import textures
from r3gw.benchmark.buildings import townhouse_street
from r3gw.benchmark.lights import Session
from r3gw.benchmark.materials import Material
from r3gw.benchmark.meshes import Mesh, Part, box, join, moulding, place, polygon, prism
from r3gw.benchmark.ornaments import CORNICE, balustrade, chimney, pediment, steps, tiled_slope
from r3gw.benchmark.place import Place, Walk, common_materials, facade, surroundings, turned_walls
from r3gw.benchmark.walls import Opening, door, surround, wall

LOW, HIGH = (-3.2, 0.0), (3.2, 4.6)
WIDTH, DEPTH = 6.4, 4.6
BASE, TOP = 1.75, 4.75  # Ground storey up to BASE, brick up to TOP
AXES = (0.85, 2.0, 3.2, 4.4, 5.55)


def build(random: np.random.Generator) -> tuple[list[Part], dict[str, Material]]:
    """Parts and materials of the place."""
    parts = surroundings(random) + _ground_storey() + _upper_storeys() + _roof()
    parts += townhouse_street.parts(random)
    brick = (0.36, 0.13, 0.08)
    own = {
        "brick": Material(
            textures.blocks(
                random, brick, 28, 9, joint=(0.4, 0.35, 0.29), joint_px=3, variation=0.16
            ),
            2.4,
            roughness=0.8,
        ),
        "stone": Material(textures.plaster(random, (0.56, 0.52, 0.45), 0.07), 3.0, roughness=0.7),
        "trim": Material(textures.plaster(random, (0.66, 0.62, 0.54), 0.05), 3.0, roughness=0.55),
        "granite": Material(
            textures.speckle(random, (0.05, 0.05, 0.055), (0.16, 0.15, 0.15), 0.1), 1.0, 0.28
        ),
        "tiles": Material(
            textures.blocks(
                random, (0.3, 0.11, 0.065), 14, 16, joint=(0.12, 0.05, 0.035), variation=0.2
            ),
            2.6,
            roughness=0.6,
        ),
        "yellow": Material(textures.plaster(random, (0.66, 0.5, 0.24), 0.08), 3.0, roughness=0.8),
        "door": Material(textures.planks(random, (0.03, 0.07, 0.13), 8), 1.0, roughness=0.3),
        "shutter": Material(textures.planks(random, (0.06, 0.17, 0.11), 10), 0.8, roughness=0.5),
        "awning": Material(
            textures.blocks(
                random, (0.6, 0.56, 0.47), 1, 8, joint=(0.45, 0.05, 0.05), joint_px=32, shift=0.0
            ),
            1.6,
        ),
        "zinc": Material((0.3, 0.32, 0.34), roughness=0.35),
    }
    return parts, common_materials(random) | own


def _ground_storey() -> list[Part]:
    """Rusticated stone with arched windows, a portal with columns of blocks, a granite plinth."""
    portal = Opening(2.75, 3.65, 0.28, 1.62, True, 0.3)
    arches = [Opening(x - 0.3, x + 0.3, 0.62, 1.5, True, 0.24) for x in AXES if x != 3.2]
    front = facade(WIDTH, BASE, arches, "stone", (2, 2))[1:]
    front = [("stone", wall(WIDTH, BASE, [portal, *arches])), *front, *door(portal)]
    front.append(("stone", join(_rustication([portal, *arches]))))
    front += [("trim", surround(o, 0.1, 0.1)) for o in (portal, *arches)]
    for o in (portal, *arches):
        key = prism([(-0.07, 0), (0.07, 0), (0.1, 0.24), (-0.1, 0.24)], -0.15, 0)
        front.append(("trim", key.placed(0.0, (o.middle, 0, o.top - 0.03))))
    side_windows = [Opening(y - 0.3, y + 0.3, 0.62, 1.45, False, 0.2) for y in (1.0, 2.3, 3.6)]
    side = facade(DEPTH, BASE, side_windows, "stone", (2, 2))
    back = [("stone", wall(WIDTH, BASE, []))]
    parts = turned_walls(LOW, HIGH, {"front": front, "right": side, "left": side, "back": back})
    flight = steps((-0.65, -0.4), (0.65, 0.1), 2, 0.14, 0.24)
    plinth = moulding(LOW, HIGH, [(0.13, 0.0), (0.13, 0.34), (0.09, 0.4), (0.0, 0.4)])
    return [*parts, ("trim", flight), ("granite", plinth)]


def _rustication(holes: list[Opening]) -> list[Mesh]:
    """Raised blocks in courses, left out around the holes."""
    blocks = []
    course, length = 0.225, 0.64
    for row in range(6):
        z = 0.41 + row * course
        start = -0.5 * length * (row % 2)
        for x in np.arange(start, WIDTH, length):
            low, high = max(x + 0.015, 0.0), min(x + length - 0.015, WIDTH)
            for hole in holes:
                if z < hole.top + 0.1 and z + course > hole.bottom:
                    if low < hole.middle < high:
                        high = low
                    if hole.left - 0.1 < high <= hole.right + 0.1 and low < hole.left:
                        high = min(high, hole.left - 0.11)
                    if hole.left - 0.1 <= low < hole.right + 0.1:
                        low = max(low, hole.right + 0.11)
            if high - low > 0.05:
                blocks.append(box((low, -0.055, z + 0.015), (high, 0, z + course - 0.015)))
    return blocks


def _upper_storeys() -> list[Part]:
    """Brick with quoins, two rows of windows, pediments over the lower row, and a balcony."""
    z1, z2 = 2.25, 3.72
    noble = [Opening(x - 0.28, x + 0.28, z1, z1 + 1.02, False, 0.18) for x in AXES]
    attic = [Opening(x - 0.26, x + 0.26, z2, z2 + 0.72, False, 0.18) for x in AXES]
    noble[2] = Opening(2.9, 3.5, BASE + 0.12, z1 + 1.05, False, 0.18)
    rows = [_lowered(o) for o in (*noble, *attic)]
    front = place(facade(WIDTH, TOP - BASE, rows, "brick", (2, 3)), 0, (0, 0, BASE))
    front += [("trim", surround(o, 0.09, 0.05)) for o in (*noble, *attic)]
    for i, o in enumerate(noble):
        left = o.left - 0.2
        if i % 2 == 0:
            hood = pediment(0.96, 0.2, 0.12, 0.1).placed(0.0, (o.middle - 0.48, -0.1, o.top + 0.16))
        else:
            hood = box((left, -0.18, o.top + 0.12), (o.right + 0.2, 0, o.top + 0.2))
        front.append(("trim", hood))
        if i != 2:
            for x in (o.left - 0.33, o.right + 0.05):
                front.append(("shutter", box((x, -0.07, o.bottom), (x + 0.28, -0.02, o.top))))
    side_rows = [
        Opening(y - 0.27, y + 0.27, z, z + 0.9, False, 0.18)
        for y in (1.0, 2.3, 3.6)
        for z in (0.55, 1.95)
    ]
    side = place(facade(DEPTH, TOP - BASE, side_rows, "brick", (2, 3)), 0, (0, 0, BASE))
    back = place([("brick", wall(WIDTH, TOP - BASE, []))], 0, (0, 0, BASE))
    parts = turned_walls(LOW, HIGH, {"front": front, "right": side, "left": side, "back": back})
    band = [(0.0, 0.0), (0.06, 0.03), (0.06, 0.12), (0.12, 0.16), (0.12, 0.22), (0.0, 0.26)]
    parts.append(("trim", moulding(LOW, HIGH, band).placed(0.0, (0, 0, BASE - 0.12))))
    parts += [("trim", join(_quoins())), *_balcony()]
    return parts


def _lowered(opening: Opening) -> Opening:
    """An opening in the coordinates of the brick wall, whose foot is at BASE."""
    o = opening
    return Opening(o.left, o.right, o.bottom - BASE, o.top - BASE, o.is_arched, o.depth)


def _quoins() -> list[Mesh]:
    """Corner blocks, long and short in turn."""
    blocks = []
    for i, z in enumerate(np.arange(BASE + 0.16, TOP - 0.2, 0.235)):
        wide, deep = (0.42, 0.26) if i % 2 else (0.26, 0.42)
        for x, side in ((LOW[0], 1), (HIGH[0], -1)):
            x0, x1 = sorted((x - side * 0.05, x + side * wide))
            blocks.append(box((x0, -0.05, z), (x1, deep, z + 0.21)))
    return blocks


def _balcony() -> list[Part]:
    """A stone balcony on brackets over the portal."""
    z = BASE + 0.02
    slab = box((-0.95, -0.62, z), (0.95, 0, z + 0.1))
    brackets = [
        prism([(-0.5, 0.0), (0, -0.34), (0, 0.0)], -0.06, 0.06).placed(90.0, (x, 0, z))
        for x in (-0.75, 0.75)
    ]
    rails = [balustrade(1.8, 0.5).placed(0.0, (-0.9, -0.54, z + 0.1))]
    rails += [balustrade(0.46, 0.5).placed(90.0, (x, -0.5, z + 0.1)) for x in (-0.9, 0.9)]
    return [("trim", join([slab, *brackets, *rails]))]


def _roof() -> list[Part]:
    """Cornice with dentils, a steep tiled roof with dormers, and chimneys."""
    dentils = [
        box((x, -0.12, TOP + 0.0), (x + 0.09, 0, TOP + 0.1)) for x in np.arange(-3.15, 3.1, 0.2)
    ]
    cornice = [(o * 1.4, z * 1.3) for o, z in CORNICE]
    z = TOP + 0.1 + cornice[-1][1]
    rise, run = 1.7, 1.5
    slope = tiled_slope(WIDTH + 0.5, run, rise, 10)
    front = slope.placed(0.0, (-3.45, -0.25, z))
    back = slope.placed(180.0, (3.45, DEPTH + 0.25, z))
    flat = [(-3.45, -0.25 + run), (3.45, -0.25 + run), (3.45, 4.85 - run), (-3.45, 4.85 - run)]
    outline = [(-0.25, z), (4.85, z), (4.85 - run, z + rise), (-0.25 + run, z + rise)]
    ends = [prism(outline, 0, 0.06).placed(90.0, (x, 0, 0)) for x in (-3.4, 3.46)]
    parts: list[Part] = [
        ("trim", join(dentils)),
        ("trim", moulding(LOW, HIGH, cornice).placed(0.0, (0, 0, TOP + 0.1))),
        ("tiles", join([front, back])),
        ("brick", join(ends)),
        ("zinc", polygon([(x, y, z + rise) for x, y in flat])),
        ("brick", chimney(-2.5, 2.3, z + rise - 0.2, 1.1)),
        ("brick", chimney(2.6, 2.6, z + rise - 0.2, 0.95)),
    ]
    for x in (-1.9, 0.0, 1.9):
        parts += place(_dormer(), 0, (x, 0.12, z + 0.3))
    return parts


def _dormer() -> list[Part]:
    """A dormer window with cheeks and a little pediment, its front in the plane y = 0."""
    hole = Opening(0.12, 0.68, 0.12, 0.85, True, 0.12)
    face = place(facade(0.8, 0.95, [hole], "trim", (2, 2)), 0, (-0.4, 0, 0))
    cheeks = [box((x, 0.0, 0.0), (x + 0.05, 1.0, 0.95)) for x in (-0.4, 0.35)]
    hood = pediment(1.0, 0.28, 1.1, 0.08).placed(0.0, (-0.5, -0.04, 0.97))
    return [*face, ("zinc", join(cheeks)), ("trim", hood)]


PLACE = Place(
    "townhouse",
    (
        Session("06-05_08_50", 110.0, 33.0, 2.8, 0.0, 0.2),
        Session("06-05_14_30", 211.0, 50.0, 3.4, 0.05, 0.45),
        Session("25-06_20_10", 274.0, 13.0, 3.2, 0.0, 0.3),
        Session("13-08_12_10", 176.0, 57.0, 2.2, 0.0, 0.1),
        Session("01-11_10_00", 148.0, 21.0, 6.5, 0.45, 0.45),
        Session("18-02_14_50", 217.0, 22.0, 4.0, 0.95, 0.2),
        Session("10-07_10_40", 134.0, 48.0, 3.0, 0.0, 0.35, True),
        Session("10-07_18_00", 252.0, 28.0, 2.8, 0.0, 0.2, True),
        Session("22-03_13_00", 190.0, 38.0, 4.5, 0.25, 0.5, True),
        Session("04-12_12_30", 183.0, 19.0, 5.0, 0.75, 0.4, True),
    ),
    Walk((-0.6, 1.0, 3.6), 9.6, 11.8, 46.0, 1.15, (0.74, 1.0)),
    build,
)
