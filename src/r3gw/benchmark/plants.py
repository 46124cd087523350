"""Vegetation from leaf cards: trees, bushes, hedges, tufts of grass. Feet at z = 0."""

from collections.abc import Sequence

import numpy as np

from r3gw.benchmark.meshes import Array, Mesh, Number, Part, Vector, lathe


def leaves(
    random: np.random.Generator, centres: Array, size: Number, upright: Number = 0.0
) -> Mesh:
    """One small quad per centre ``[N, 3]``, turned at random; ``upright`` 1 stands it up."""
    count = len(centres)
    normals = random.standard_normal((count, 3)) * np.array([1.0, 1.0, 1.0 - upright])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    across = np.cross(normals, random.standard_normal((count, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    along = np.cross(normals, across)
    half = size * random.uniform(0.6, 1.2, (count, 1)) / 2
    corners = np.stack(
        [
            centres - along * half * 1.4,
            centres + across * half,
            centres + along * half * 1.4,
            centres - across * half,
        ],
        axis=1,
    )
    first = 4 * np.arange(count)[:, None]
    faces = np.concatenate([first + np.array(corner) for corner in ((0, 1, 2), (0, 2, 3))])
    patch = random.uniform(0, 1, (count, 1, 2))
    uvs = patch + np.array([(0.0, -0.02), (0.02, 0.0), (0.0, 0.02), (-0.02, 0.0)])
    return Mesh(corners.reshape(-1, 3), np.repeat(normals, 4, axis=0), uvs.reshape(-1, 2), faces)


def cloud(random: np.random.Generator, centre: Vector, radii: Vector, count: int) -> Array:
    """Points ``[count, 3]`` in the outer part of an ellipsoid with lumps."""
    directions = random.standard_normal((count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    lumps = random.standard_normal((5, 3)) * 2.2
    wave = np.sin(directions @ lumps.T + random.uniform(0, 6.28, 5)).mean(axis=1)
    reach = random.uniform(0.45, 1.0, count) ** 0.5 * (1.0 + 0.28 * wave)
    offsets: Array = directions * reach[:, None] * np.asarray(radii)
    return np.add(offsets, centre)


def tree(
    random: np.random.Generator, height: Number, spread: Number, count: int = 1300
) -> list[Part]:
    """A broad-leaved tree: a trunk and a crown of several leaf clouds."""
    bole = 0.045 * height
    trunk = lathe([(bole * 1.5, 0), (bole, 0.08 * height), (bole * 0.6, 0.7 * height)], 9)
    clumps = 6
    turn = np.arange(clumps) * 2.4 + random.uniform(0, 6.28)
    points = [
        cloud(
            random,
            (
                spread * 0.45 * np.cos(a),
                spread * 0.45 * np.sin(a),
                height * (0.5 + 0.28 * i / clumps) + random.uniform(-0.05, 0.05) * height,
            ),
            (spread * 0.55, spread * 0.55, height * 0.2),
            count // (clumps + 1),
        )
        for i, a in enumerate(turn)
    ]
    top = cloud(
        random,
        (0, 0, 0.78 * height),
        (spread * 0.6, spread * 0.6, 0.24 * height),
        count // (clumps + 1),
    )
    crown = leaves(random, np.concatenate([*points, top]), 0.05 * height)
    return [("bark", trunk), ("leaves", crown)]


def cypress(random: np.random.Generator, height: Number, count: int = 1500) -> list[Part]:
    """A narrow, dark tree."""
    f = random.uniform(0.02, 1.0, count)
    radius = 0.16 * height * np.sin(np.pi * f**0.65) * random.uniform(0.5, 1.0, count)
    turn = random.uniform(0, 2 * np.pi, count)
    points = np.stack([radius * np.cos(turn), radius * np.sin(turn), f * height], axis=1)
    trunk = lathe([(0.06, 0), (0.04, height * 0.5)], 8)
    return [("bark", trunk), ("needles", leaves(random, points, 0.042 * height, 0.5))]


def bush(
    random: np.random.Generator, radius: Number, height: Number, count: int = 700
) -> list[Part]:
    """A rounded shrub."""
    points = cloud(random, (0, 0, height * 0.45), (radius, radius, height * 0.55), count)
    points[:, 2] = np.abs(points[:, 2])
    return [("leaves", leaves(random, points, 0.1))]


def hedge(
    random: np.random.Generator, low: Vector, high: Vector, density: Number = 700.0
) -> list[Part]:
    """A clipped hedge filling a box, ``density`` leaves per square unit of its skin."""
    lower, upper = np.asarray(low, float), np.asarray(high, float)
    x, y, z = upper - lower
    count = int(density * (x * y + 2 * z * (x + y)))
    points = random.uniform(0, 1, (count, 3))
    skin = random.choice(5, count, p=_shares([x * y, x * z, x * z, y * z, y * z]))
    for number, (axis, side) in enumerate([(2, 1.0), (1, 0.0), (1, 1.0), (0, 0.0), (0, 1.0)]):
        points[skin == number, axis] = side
    points = lower + points * (upper - lower) + 0.03 * random.standard_normal((count, 3))
    return [("needles", leaves(random, points, 0.09))]


def _shares(areas: Sequence[float]) -> Array:
    """Areas as probabilities."""
    shares: Array = np.asarray(areas) / np.sum(areas)
    return shares


def tufts(random: np.random.Generator, low: Vector, high: Vector, count: int) -> list[Part]:
    """Blades of grass scattered over a rectangle in x and y."""
    spots = random.uniform((low[0], low[1]), (high[0], high[1]), (count, 2))
    points = np.insert(spots, 2, 0.03, axis=1)
    return [("grass", leaves(random, points, 0.09, 0.9))]
