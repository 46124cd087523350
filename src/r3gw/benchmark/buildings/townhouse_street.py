"""What stands around the townhouse: a lower neighbour with a shop, and the street."""

import numpy as np

from r3gw.benchmark import plants
from r3gw.benchmark.meshes import Part, box, join, moulding, place, polygon, prism
from r3gw.benchmark.ornaments import CORNICE, chimney, gable_roof, lamp, urn
from r3gw.benchmark.place import facade, turned_walls
from r3gw.benchmark.walls import Opening, door, surround, wall


def parts(random: np.random.Generator) -> list[Part]:
    """The neighbour and the street."""
    return _neighbour() + _street(random)


def _neighbour() -> list[Part]:
    """A lower yellow house with a shop, an awning and a gable roof, set against the left side."""
    low, high = (-7.4, 0.35), (-3.2, 4.4)
    shop = Opening(0.5, 2.3, 0.35, 1.5, False, 0.25)
    entry = Opening(2.9, 3.55, 0.1, 1.5, False, 0.25)
    upper = [Opening(x - 0.28, x + 0.28, 2.15, 3.05, False, 0.16) for x in (0.75, 2.1, 3.4)]
    front = facade(4.2, 3.5, [shop, *upper], "yellow", (2, 3))[1:]
    front = [("yellow", wall(4.2, 3.5, [shop, entry, *upper])), *front, *door(entry)]
    front += [("trim", surround(o, 0.08, 0.04)) for o in (shop, entry, *upper)]
    for o in upper:
        for x in (o.left - 0.34, o.right + 0.06):
            front.append(("shutter", box((x, -0.06, o.bottom), (x + 0.28, -0.01, o.top))))
    cloth = polygon([(0.35, -0.75, 1.35), (2.45, -0.75, 1.35), (2.45, 0, 1.75), (0.35, 0, 1.75)])
    edge = -0.75
    hem = polygon([(0.35, edge, 1.2), (2.45, edge, 1.2), (2.45, edge, 1.35), (0.35, edge, 1.35)])
    front += [("awning", join([cloth, hem]))]
    side = facade(4.05, 3.5, [Opening(1.6, 2.3, 2.1, 3.0)], "yellow")
    parts = turned_walls(low, high, {"front": front, "left": side})
    parts.append(("granite", moulding(low, high, [(0.05, 0), (0.05, 0.3), (0, 0.34)])))
    parts.append(("trim", moulding(low, high, CORNICE).placed(0.0, (0, 0, 3.4))))
    roof = gable_roof((-2.03, -2.1), (2.03, 2.1), 1.35, 0.2, 10)
    gables = [prism([(-2.03, 0), (2.03, 0), (0, 1.35)], y, y + 0.1) for y in (-2.1, 2.0)]
    spot = (-5.3, 2.375, 3.62)
    parts += [("tiles", roof.placed(90.0, spot)), ("yellow", join(gables).placed(90.0, spot))]
    return [*parts, ("brick", chimney(-6.2, 2.4, 4.4, 1.1))]


def _street(random: np.random.Generator) -> list[Part]:
    """Cobbles, pavement, planters, a lamp, a bench and trees on the open side."""
    road = [(-12, -9.5, 0.01), (9, -9.5, 0.01), (9, -1.5, 0.01), (-12, -1.5, 0.01)]
    parts: list[Part] = [("paving", polygon(road))]
    parts.append(("kerb", box((-12, -1.6, 0), (9, -1.45, 0.1))))
    walk = [(-12, -1.45, 0.08), (9, -1.45, 0.08), (9, 0.4, 0.08), (-12, 0.4, 0.08)]
    parts.append(("gravel", polygon(walk)))
    for x in (-1.25, 1.25, 2.7):
        shape = [(0, 0.08), (0.03, 0.4), (0.05, 0.42), (0.05, 0.48)]
        tub = moulding((x - 0.2, -0.75), (x + 0.2, -0.35), shape)
        parts.append(("granite" if x == 2.7 else "stone", tub))
        parts += place(plants.bush(random, 0.28, 0.6, 500), 0, (x, -0.55, 0.45))
    for x in (-3.6, 4.3):
        parts += place(lamp(2.3), 0, (x, -1.2, 0.08))
    seat = [
        box((-2.6, -0.7, 0.32), (-1.6, -0.4, 0.37)),
        box((-2.6, -0.42, 0.37), (-1.6, -0.38, 0.68)),
    ]
    legs = [box((x, -0.7, 0.08), (x + 0.06, -0.4, 0.32)) for x in (-2.55, -1.71)]
    parts += [("shutter", join(seat)), ("metal", join(legs))]
    parts.append(("trim", urn(1.1).placed(0.0, (3.9, -0.4, 0.08))))
    for x, y, height in ((5.6, 0.6, 4.2), (7.6, 3.0, 5.2), (6.4, 5.2, 5.4), (-10.2, 3.2, 4.8)):
        parts += place(plants.tree(random, height, 0.42 * height), 0, (x, y, 0))
    parts += plants.hedge(random, (4.9, 0.8, 0.0), (9.0, 1.2, 0.8), 600.0)
    return parts
