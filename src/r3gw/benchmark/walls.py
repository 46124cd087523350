"""Walls with holes: rectangular and arched openings with reveals, windows, doors, surrounds.

A wall lies in the plane y = 0, from x = 0 to its width and z = 0 to its height, and faces -y;
reveals go into +y.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from r3gw.benchmark.meshes import Array, Mesh, Number, Part, box, join, polygon

ARC_SEGMENTS = 12


@dataclass(frozen=True)
class Opening:
    """A hole in a wall, in wall coordinates.

    Attributes:
        left, right: Horizontal extent.
        bottom, top: Vertical extent; for an arch ``top`` is its crown.
        is_arched: Whether a half circle closes it.
        depth: How far the window or door stands back.
    """

    left: Number
    right: Number
    bottom: Number
    top: Number
    is_arched: bool = False
    depth: Number = 0.22

    @property
    def radius(self) -> float:
        """Radius of the arch, half the width."""
        return (self.right - self.left) / 2

    @property
    def middle(self) -> float:
        """Horizontal middle."""
        return (self.right + self.left) / 2

    def outline(self, grow: Number = 0.0) -> Array:
        """Corners ``[N, 2]``, counter-clockwise from bottom left; sides and top move out."""
        left, right, top = self.left - grow, self.right + grow, self.top + grow
        if not self.is_arched:
            return np.array([(left, self.bottom), (right, self.bottom), (right, top), (left, top)])
        turn = np.linspace(0.0, np.pi, ARC_SEGMENTS + 1)
        radius = self.radius + grow
        spring = self.top - self.radius
        arc = np.stack([self.middle + radius * np.cos(turn), spring + radius * np.sin(turn)], 1)
        return np.concatenate([[(left, self.bottom), (right, self.bottom)], arc])


def wall(width: Number, height: Number, openings: Sequence[Opening]) -> Mesh:
    """The wall's face with its holes, and the reveals."""
    xs = sorted({0.0, width, *(x for o in openings for x in (o.left, o.right))})
    zs = sorted({0.0, height, *(z for o in openings for z in (o.bottom, o.top))})
    faces = []
    for x0, x1 in pairwise(xs):
        for z0, z1 in pairwise(zs):
            x, z = (x0 + x1) / 2, (z0 + z1) / 2
            if not any(o.left < x < o.right and o.bottom < z < o.top for o in openings):
                faces.append(polygon([(x0, 0, z0), (x1, 0, z0), (x1, 0, z1), (x0, 0, z1)]))
    for opening in openings:
        faces += _reveal(opening.outline(), opening.depth)
        if opening.is_arched:
            faces += _spandrels(opening)
    return join(faces)


def _reveal(outline: Array, depth: Number) -> list[Mesh]:
    """The inside faces of a hole."""
    pairs = zip(outline, np.roll(outline, -1, axis=0), strict=True)
    return [
        polygon([(a[0], 0, a[1]), (b[0], 0, b[1]), (b[0], depth, b[1]), (a[0], depth, a[1])])
        for a, b in pairs
        if np.linalg.norm(b - a) > 1e-9
    ]


def _spandrels(opening: Opening) -> list[Mesh]:
    """The wall between an arch and the rectangle around it."""
    arc, top = opening.outline()[2:], opening.top
    faces = []
    for a, b in pairwise(arc):
        corners = [(b[0], 0, b[1]), (a[0], 0, a[1]), (a[0], 0, top), (b[0], 0, top)]
        faces.append(polygon([c for i, c in enumerate(corners) if c != corners[i - 1]]))
    return faces


def surround(opening: Opening, width: Number, relief: Number) -> Mesh:
    """A raised band around an opening, standing ``relief`` out of the wall."""
    inner = np.roll(opening.outline(), -1, axis=0)  # From bottom right over the top to bottom left
    outer = np.roll(opening.outline(width), -1, axis=0)
    faces = []
    for i in range(len(inner) - 1):
        a, b, c, d = outer[i], outer[i + 1], inner[i + 1], inner[i]
        if np.linalg.norm(c - d) < 1e-9:
            continue
        front = [(p[0], -relief, p[1]) for p in (a, b, c, d)]
        faces.append(polygon(front))
        faces.append(polygon([(a[0], 0, a[1]), (b[0], 0, b[1]), front[1], front[0]]))
        faces.append(polygon([front[3], front[2], (c[0], 0, c[1]), (d[0], 0, d[1])]))
    return join(faces)


def window(
    opening: Opening, columns: int, rows: int, frame: str = "frame", glass: str = "glass"
) -> list[Part]:
    """Glass at the back of an opening, with a frame, glazing bars and a sill."""
    pane = polygon([(x, opening.depth, z) for x, z in opening.outline()])
    left, right, bottom, top = opening.left, opening.right, opening.bottom, opening.top
    y0, y1 = opening.depth - 0.07, opening.depth
    bar, edge = 0.022, 0.05
    bars = [
        box((left, y0, bottom), (right, y1, bottom + edge)),
        box((left, y0, bottom), (left + edge, y1, top)),
        box((right - edge, y0, bottom), (right, y1, top)),
    ]
    if not opening.is_arched:
        bars.append(box((left, y0, top - edge), (right, y1, top)))
    else:
        spring = top - opening.radius
        bars[1] = box((left, y0, bottom), (left + edge, y1, spring))
        bars[2] = box((right - edge, y0, bottom), (right, y1, spring))
        bars.append(box((left, y0, spring - edge / 2), (right, y1, spring + edge / 2)))
    for x in np.linspace(left, right, columns + 1)[1:-1]:
        bars.append(box((x - bar, y0 + 0.02, bottom), (x + bar, y1, top)))
    for z in np.linspace(bottom, top, rows + 1)[1:-1]:
        bars.append(box((left, y0 + 0.02, z - bar), (right, y1, z + bar)))
    sill = box((left - 0.1, -0.1, bottom - 0.09), (right + 0.1, opening.depth, bottom))
    return [(glass, pane), (frame, join(bars)), ("trim", sill)]


def door(opening: Opening, material: str = "door") -> list[Part]:
    """A two-leaf panelled door at the back of an opening."""
    leaf = polygon([(x, opening.depth, z) for x, z in opening.outline()])
    spring = opening.top - (opening.radius if opening.is_arched else 0.0)
    y = opening.depth
    panels = []
    for x0, x1 in ((opening.left, opening.middle), (opening.middle, opening.right)):
        for low, high in ((0.06, 0.3), (0.36, 0.66), (0.72, 0.97)):
            z0, z1 = (opening.bottom + f * (spring - opening.bottom) for f in (low, high))
            panels.append(box((x0 + 0.07, y - 0.05, z0), (x1 - 0.07, y, z1)))
    knob = box((opening.middle - 0.06, y - 0.09, 0.9), (opening.middle - 0.02, y, 0.96))
    return [(material, leaf), (material, join(panels)), ("metal", knob)]
