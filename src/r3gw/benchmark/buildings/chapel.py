"""Chapel: a limestone nave with buttresses, a round window, a portal and a bell tower."""

import numpy as np

from r3gw.benchmark import plants, textures
from r3gw.benchmark.lights import Session
from r3gw.benchmark.materials import Material
from r3gw.benchmark.meshes import Mesh, Part, box, join, lathe, moulding, place, polygon, prism
from r3gw.benchmark.ornaments import gable_roof, pyramid, steps
from r3gw.benchmark.place import Place, Walk, common_materials, facade, surroundings, turned_walls
from r3gw.benchmark.walls import Opening, door, surround, wall, window

NAVE_LOW, NAVE_HIGH = (-2.4, 0.0), (2.4, 7.0)
WALL, RIDGE = 3.3, 2.5
TOWER_LOW, TOWER_HIGH = (2.4, 0.5), (4.4, 2.5)
TOWER = 5.6


def build(random: np.random.Generator) -> tuple[list[Part], dict[str, Material]]:
    """Parts and materials of the place."""
    parts = surroundings(random) + _nave() + _front() + _tower() + _grounds(random)
    lime = (0.56, 0.49, 0.37)
    own = {
        "stone": Material(
            textures.blocks(random, lime, 12, 5, joint=(0.36, 0.32, 0.26), variation=0.1),
            4.0,
            roughness=0.75,
        ),
        "trim": Material(textures.plaster(random, (0.62, 0.57, 0.47), 0.05), 3.0, roughness=0.6),
        "slate": Material(
            textures.blocks(random, (0.13, 0.14, 0.16), 16, 14, joint=(0.06, 0.06, 0.07)),
            3.0,
            roughness=0.4,
        ),
        "door": Material(textures.planks(random, (0.2, 0.085, 0.04)), 1.6, roughness=0.45),
        "headstone": Material(textures.marble(random, (0.3, 0.3, 0.29), (0.2, 0.2, 0.2)), 1.0, 0.3),
    }
    return parts, common_materials(random) | own


def _nave() -> list[Part]:
    """Side walls with lancets and buttresses, back, plinth, cornice and roof."""
    lancets = [Opening(y - 0.32, y + 0.32, 0.95, 2.75, True, 0.28) for y in (0.95, 2.5, 4.1, 5.7)]
    side = facade(7.0, WALL, lancets, "stone", (2, 4))
    side += [("trim", surround(o, 0.12, 0.05)) for o in lancets]
    for x in (0.12, 1.72, 3.3, 4.9, 6.7):
        pier = box((x - 0.17, -0.42, 0), (x + 0.17, 0, 2.1))
        cap = prism([(-0.42, 2.1), (0, 2.1), (0, 2.7)], -0.17, 0.17)
        side += [("stone", pier), ("trim", cap.placed(90.0, (x, 0, 0)))]
    back = [("stone", wall(4.8, WALL, []))]
    parts = turned_walls(NAVE_LOW, NAVE_HIGH, {"right": side, "left": side, "back": back})
    plinth = [(0.1, 0.0), (0.1, 0.42), (0.03, 0.5), (0.0, 0.5)]
    eaves = [(0.0, 0.0), (0.04, 0.05), (0.04, 0.1), (0.14, 0.16), (0.14, 0.22)]
    roof = gable_roof(NAVE_LOW, NAVE_HIGH, RIDGE, 0.28, 14)
    return [
        *parts,
        ("trim", moulding(NAVE_LOW, NAVE_HIGH, plinth)),
        ("trim", moulding(NAVE_LOW, NAVE_HIGH, eaves).placed(0.0, (0, 0, WALL - 0.2))),
        ("slate", roof.placed(0.0, (0, 0, WALL + 0.05))),
        ("stone", prism([(-2.4, WALL), (2.4, WALL), (0, WALL + RIDGE)], 0.0, 0.3)),
        ("stone", prism([(-2.4, WALL), (2.4, WALL), (0, WALL + RIDGE)], 6.7, 7.0)),
    ]


def _front() -> list[Part]:
    """The gabled front: stepped portal, round window, string course and a cross."""
    portal = Opening(1.75, 3.05, 0.0, 2.25, True, 0.5)
    niches = [Opening(x - 0.22, x + 0.22, 1.0, 2.3, True, 0.2) for x in (0.85, 3.95)]
    front: list[Part] = [("stone", wall(4.8, WALL, [portal, *niches])), *door(portal)]
    for niche in niches:
        front += window(niche, 1, 3)
        front.append(("trim", surround(niche, 0.1, 0.05)))
    for width, relief in ((0.12, 0.22), (0.24, 0.15), (0.36, 0.08)):
        front.append(("trim", surround(portal, width, relief)))
    for x in (1.48, 3.32):
        shaft = lathe([(0.09, 0), (0.09, 0.1), (0.06, 0.14), (0.06, 1.5), (0.1, 1.62)], 12)
        front.append(("trim", shaft.placed(0.0, (x, -0.22, 0))))
    front += _rose((2.4, 3.75), 0.72)
    front.append(("trim", box((-0.05, -0.1, 2.72), (4.85, 0, 2.86))))
    rake = np.degrees(np.arctan2(RIDGE, 2.4))
    front += [("trim", _coping(rake)), ("trim", _mirror(_coping(rake)))]
    front.append(("trim", box((2.33, -0.05, 5.75), (2.47, 0.1, 6.6))))
    front.append(("trim", box((2.12, -0.05, 6.18), (2.68, 0.1, 6.32))))
    parts = turned_walls(NAVE_LOW, NAVE_HIGH, {"front": front})
    flight = steps((-1.1, -0.75), (1.1, 0.0), 3, 0.1, 0.24)
    return [*parts, ("trim", flight.placed(0.0, (0, 0, 0)))]


def _coping(angle_deg: float) -> Mesh:
    """The raised edge of the left half of the gable, in wall coordinates."""
    angle = np.radians(angle_deg)
    along, up = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    length = np.hypot(RIDGE, 2.4)
    corners = [(-0.32, -0.02), (length + 0.1, -0.02), (length + 0.02, 0.2), (-0.32, 0.2)]
    outline = [np.array([0.0, WALL]) + a * along + b * up for a, b in corners]
    return prism(outline, -0.12, 0.3)


def _mirror(mesh: Mesh) -> Mesh:
    """Reflect front parts about the middle of the front."""
    flip = np.array([-1.0, 1.0, 1.0])
    moved = mesh.vertices * flip + np.array([4.8, 0, 0])
    return Mesh(moved, mesh.normals * flip, mesh.uvs, mesh.faces[:, ::-1].copy())


def _rose(middle: tuple[float, float], radius: float) -> list[Part]:
    """A round window on the wall: rings of moulding, glass and tracery."""
    ring = lathe(
        [
            (radius + 0.2, 0.0),
            (radius + 0.18, 0.1),
            (radius + 0.08, 0.14),
            (radius, 0.1),
            (radius - 0.06, 0.03),
        ],
        28,
    )
    turns = np.linspace(0, 2 * np.pi, 25)[:-1]
    pane = polygon([(radius * np.cos(t), radius * np.sin(t), 0.015) for t in turns])
    hub = lathe([(0.17, 0.0), (0.17, 0.07), (0.1, 0.07), (0.1, 0.02)], 14)
    spokes = [
        box((0.12, -0.025, 0.0), (radius, 0.025, 0.07)).placed(a) for a in np.arange(0, 360, 45.0)
    ]
    parts: list[Part] = [("trim", join([ring, hub, *spokes])), ("glass", pane)]
    return [(name, _upright(mesh, middle)) for name, mesh in parts]


def _upright(mesh: Mesh, middle: tuple[float, float]) -> Mesh:
    """Turn a shape lying on the ground so that it stands on a wall, its top towards -y."""
    turn = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    moved = mesh.vertices @ turn.T + np.array([middle[0], 0.0, middle[1]])
    return Mesh(moved, mesh.normals @ turn.T, mesh.uvs, mesh.faces)


def _tower() -> list[Part]:
    """The bell tower with louvred arches and a pyramid roof."""
    slit = Opening(0.85, 1.15, 1.6, 2.7, True, 0.3)
    bell = [Opening(x - 0.3, x + 0.3, 4.1, 5.25, True, 0.3) for x in (0.55, 1.45)]
    face: list[Part] = [("stone", wall(2.0, TOWER, [slit, *bell])), *window(slit, 1, 3)]
    for opening in bell:
        face.append(("metal", polygon([(x, 0.3, z) for x, z in opening.outline()])))
        louvres = [
            box((opening.left, 0.08, z), (opening.right, 0.26, z + 0.04))
            for z in np.arange(4.15, 5.1, 0.14)
        ]
        face += [("trim", join(louvres)), ("trim", surround(opening, 0.09, 0.05))]
    sides = dict.fromkeys(("front", "right", "back", "left"), face)
    parts = turned_walls(TOWER_LOW, TOWER_HIGH, sides)
    band = [(0.0, 0.0), (0.08, 0.04), (0.08, 0.12), (0.0, 0.16)]
    crown = [(0.0, 0.0), (0.06, 0.05), (0.06, 0.12), (0.18, 0.2), (0.18, 0.3)]
    roof = pyramid((2.2, 0.3), (4.6, 2.7), 1.9, 10)
    plinth = [(0.12, 0.0), (0.12, 0.5), (0.0, 0.62)]
    for x, y in ((2.4, 0.5), (4.4, 0.5), (4.4, 2.5), (2.4, 2.5)):
        parts.append(("trim", box((x - 0.14, y - 0.14, 0), (x + 0.14, y + 0.14, 3.7))))
    return [
        *parts,
        ("trim", moulding(TOWER_LOW, TOWER_HIGH, plinth)),
        *(
            ("trim", moulding(TOWER_LOW, TOWER_HIGH, band).placed(0.0, (0, 0, z)))
            for z in (3.0, 3.7)
        ),
        ("trim", moulding(TOWER_LOW, TOWER_HIGH, crown).placed(0.0, (0, 0, TOWER - 0.1))),
        ("slate", roof.placed(0.0, (0, 0, TOWER + 0.2))),
        (
            "metal",
            lathe([(0.03, 0), (0.02, 0.7), (0.09, 0.75), (0.0, 0.9)], 8).placed(
                0, (3.4, 1.5, TOWER + 2.05)
            ),
        ),
    ]


def _grounds(random: np.random.Generator) -> list[Part]:
    """Churchyard: a paved forecourt, gravel, graves, walls, cypresses and bushes."""
    court = [(-1.6, -9, 0.015), (1.6, -9, 0.015), (1.6, -0.2, 0.015), (-1.6, -0.2, 0.015)]
    cross = [(-6.5, -3.4, 0.01), (6.5, -3.4, 0.01), (6.5, -1.6, 0.01), (-6.5, -1.6, 0.01)]
    parts: list[Part] = [("paving", polygon(court)), ("gravel", polygon(cross))]
    for x in (-1.72, 1.6):
        parts += [("kerb", box((x, -9, 0), (x + 0.12, -3.4, 0.1)))]
    for x, y, turn in (
        (-3.6, -4.6, 8),
        (-4.7, -4.2, -5),
        (3.4, -4.9, 4),
        (4.6, -4.4, -9),
        (-4.2, -0.6, 2),
    ):
        stone = prism([(-0.24, 0), (0.24, 0), (0.24, 0.62), (0, 0.8), (-0.24, 0.62)], 0, 0.14)
        parts += place([("headstone", stone)], turn, (x, y, 0))
    for x, y, height in ((-4.0, 1.2, 4.4), (-4.6, 4.2, 5.0), (6.4, 1.0, 4.0), (6.2, 4.5, 4.6)):
        parts += place(plants.cypress(random, height), 0, (x, y, 0))
    for x, y, r in ((-2.6, -0.75, 0.45), (-3.3, -0.9, 0.38), (5.4, -0.6, 0.55), (2.3, -0.7, 0.35)):
        parts += place(plants.bush(random, r, 1.4 * r), 0, (x, y, 0))
    parts += place(plants.tree(random, 4.6, 2.2), 0, (-8.2, 2.8, 0))
    parts += place(plants.tree(random, 5.2, 2.4), 0, (9.0, 4.6, 0))
    parts += plants.tufts(random, (-7, -8), (-1.8, -3.5), 1100)
    parts += plants.tufts(random, (1.8, -8), (7, -3.5), 1100)
    low_wall = [box((-9, 7.6, 0), (9, 7.9, 1.0)), box((-9.05, 7.55, 1.0), (9.05, 7.95, 1.1))]
    return [*parts, ("stone", join(low_wall))]


PLACE = Place(
    "chapel",
    (
        Session("14-04_09_10", 118.0, 27.0, 2.6, 0.0, 0.25),
        Session("14-04_13_40", 196.0, 52.0, 3.0, 0.0, 0.4),
        Session("02-06_18_20", 257.0, 22.0, 4.0, 0.0, 0.2),
        Session("21-08_11_00", 160.0, 46.0, 5.5, 0.35, 0.5),
        Session("09-10_15_30", 228.0, 30.0, 3.0, 0.95, 0.3),
        Session("30-11_08_40", 139.0, 12.0, 3.2, 0.1, 0.35),
        Session("17-05_10_30", 137.0, 41.0, 2.8, 0.0, 0.15, True),
        Session("17-05_17_10", 241.0, 33.0, 3.4, 0.05, 0.35, True),
        Session("05-09_12_20", 178.0, 44.0, 6.0, 0.6, 0.4, True),
        Session("26-02_15_50", 214.0, 18.0, 2.4, 0.0, 0.3, True),
    ),
    Walk((0.7, 1.0, 3.0), 9.2, 11.8, 52.0, 1.15, (0.76, 1.02)),
    build,
)
