"""Triangle meshes with flat or smooth normals: boxes, prisms, turned profiles, mouldings.

Building axes: x right, y away from the street, z up, right-handed; a facade at y = 0 faces -y.
Texture coordinates are in length units, so that a material alone decides the size of its pattern.
A part is a mesh with the name of its material; a building is a list of parts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, radians, sin

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Number = float | int
Vector = Sequence[Number] | Array
Points = Sequence[Vector] | Array


@dataclass(frozen=True)
class Mesh:
    """Triangles with their own normals and texture coordinates.

    Attributes:
        vertices: ``[N, 3]`` positions.
        normals: ``[N, 3]`` unit normals, outwards.
        uvs: ``[N, 2]`` texture coordinates, in length units.
        faces: ``[M, 3]`` vertex numbers.
    """

    vertices: Array
    normals: Array
    uvs: Array
    faces: NDArray[np.int64]

    def placed(self, turn_deg: Number = 0.0, offset: Vector = (0.0, 0.0, 0.0)) -> "Mesh":
        """The mesh turned about z (counter-clockwise seen from above), then moved."""
        c, s = cos(radians(turn_deg)), sin(radians(turn_deg))
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        moved = self.vertices @ turn.T + np.asarray(offset, dtype=np.float64)
        return Mesh(moved, self.normals @ turn.T, self.uvs, self.faces)


Part = tuple[str, Mesh]


def place(parts: Sequence[Part], turn_deg: Number, offset: Vector) -> list[Part]:
    """Turn and move every part as `Mesh.placed` does."""
    return [(material, mesh.placed(turn_deg, offset)) for material, mesh in parts]


def join(meshes: Sequence[Mesh]) -> Mesh:
    """Put meshes into one, in their order."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.uvs for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]),
    )


def polygon(corners: Points) -> Mesh:
    """Flat convex polygon ``[N, 3]``, counter-clockwise seen from outside."""
    points = np.asarray(corners, dtype=np.float64)
    ahead = np.roll(points, -1, axis=0)
    normal = np.cross(points, ahead).sum(axis=0)  # Newell's method
    normal /= max(float(np.linalg.norm(normal)), 1e-12)  # A sliver without area is never hit
    count = len(points)
    middle = np.arange(1, count - 1)
    faces = np.stack([np.zeros_like(middle), middle, middle + 1], axis=1)
    return Mesh(points, np.tile(normal, (count, 1)), _flat_uvs(points, normal), faces)


def _flat_uvs(points: Array, normal: Array) -> Array:
    """Lengths along the two directions of a plane: level and steepest upwards (or x and y)."""
    level = np.array([-normal[1], normal[0], 0.0])
    if np.linalg.norm(level) < 1e-6:
        return points[:, :2].copy()
    level /= np.linalg.norm(level)
    return np.stack([points @ level, points @ np.cross(normal, level)], axis=1)


def box(low: Vector, high: Vector) -> Mesh:
    """Box between two corners, six flat faces."""
    (x0, y0, z0), (x1, y1, z1) = np.asarray(low, float), np.asarray(high, float)
    a, b, c, d = (x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)
    e, f, g, h = (x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)
    sides = [(a, b, f, e), (b, c, g, f), (c, d, h, g), (d, a, e, h), (e, f, g, h), (d, c, b, a)]
    return join([polygon(side) for side in sides])


def prism(outline: Points, y0: Number, y1: Number) -> Mesh:
    """Convex outline ``[N, 2]`` in x and z, counter-clockwise seen from -y, from y0 to y1."""
    points = np.asarray(outline, dtype=np.float64)
    front = np.insert(points, 1, y0, axis=1)
    back = np.insert(points, 1, y1, axis=1)
    pairs = zip(front, np.roll(front, -1, 0), back, np.roll(back, -1, 0), strict=True)
    sides = [polygon([a, c, d, b]) for a, b, c, d in pairs]
    return join([polygon(front), polygon(back[::-1]), *sides])


def lathe(profile: Points, sides: int = 20, smooth: bool = True) -> Mesh:
    """Turn a profile ``[N, 2]`` of (radius, z), upwards, about the z axis.

    Normals are smooth around the axis (flat for ``smooth=False``), hard along the profile.
    """
    points = np.asarray(profile, dtype=np.float64)
    angles = np.linspace(0.0, 2 * np.pi, sides + 1)
    bands = [
        _band(low, high, angles, smooth)
        for low, high in pairwise(points)
        if np.linalg.norm(high - low) > 1e-9
    ]
    return join(bands)


def _band(low: Array, high: Array, angles: Array, smooth: bool) -> Mesh:
    """One ring of a turned profile."""
    radial = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    rings = [radial * r + np.array([0.0, 0.0, z]) for r, z in (low, high)]
    if not smooth:
        quads = zip(rings[0][:-1], rings[0][1:], rings[1][1:], rings[1][:-1], strict=True)
        return join([polygon(_distinct(quad)) for quad in quads])
    across, up = high[1] - low[1], low[0] - high[0]
    length = np.hypot(across, up)
    normals = radial * (across / length) + np.array([0.0, 0.0, up / length])
    girth = angles * max(low[0], high[0])
    uvs = [np.stack([girth, np.full_like(girth, v)], axis=1) for v in (low[1], low[1] + length)]
    count = len(angles)
    i = np.arange(count - 1)
    faces = np.concatenate(
        [np.stack([i, i + 1, count + i + 1], 1), np.stack([i, count + i + 1, count + i], 1)]
    )
    return Mesh(np.concatenate(rings), np.tile(normals, (2, 1)), np.concatenate(uvs), faces)


def _distinct(corners: Sequence[Array]) -> list[Array]:
    """Corners without repetitions of the one before (a quad at the axis is a triangle)."""
    return [p for i, p in enumerate(corners) if np.linalg.norm(p - corners[i - 1]) > 1e-9]


def moulding(low: Vector, high: Vector, profile: Points) -> Mesh:
    """Run a profile ``[N, 2]`` of (outward offset, z), upwards, around a rectangle in x and y.

    The top is closed, so that a moulding is a cornice, a plinth or a flight of steps.
    """
    (x0, y0), (x1, y1) = low, high
    rings = [
        [(x0 - o, y0 - o, z), (x1 + o, y0 - o, z), (x1 + o, y1 + o, z), (x0 - o, y1 + o, z)]
        for o, z in np.asarray(profile, dtype=np.float64)
    ]
    faces = [polygon(rings[-1])]
    for lower, upper in pairwise(rings):
        for i in range(4):
            j = (i + 1) % 4
            quad = [lower[i], lower[j], upper[j], upper[i]]
            faces.append(polygon(_distinct([np.asarray(corner) for corner in quad])))
    return join(faces)
