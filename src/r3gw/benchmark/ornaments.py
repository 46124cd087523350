"""Stock pieces of buildings: columns, balustrades, pediments, roofs, chimneys, lamps, urns."""

from math import atan2, cos, degrees, hypot, radians, sin

import numpy as np

from r3gw.benchmark.meshes import (
    Mesh,
    Number,
    Part,
    Vector,
    box,
    join,
    lathe,
    moulding,
    polygon,
    prism,
)

CORNICE = ((0.0, 0.0), (0.05, 0.02), (0.07, 0.08), (0.15, 0.14), (0.22, 0.16), (0.22, 0.24))


def column(height: Number, radius: Number, sides: int = 20) -> Mesh:
    """A Tuscan column with base, entasis, necking, echinus and abacus, its foot at the origin."""
    shaft = [
        (radius * (1.0 - 0.16 * f**1.8), 0.13 * height / 3 + f * height * 0.86)
        for f in np.linspace(0.0, 1.0, 9)
    ]
    foot, top = shaft[0][1], shaft[-1][1]
    neck = shaft[-1][0]
    r = radius
    profile = [
        (1.32 * r, 0.0),
        (1.36 * r, foot * 0.35),
        (1.3 * r, foot * 0.6),
        (1.12 * r, foot * 0.7),
        (1.15 * r, foot * 0.9),
        *shaft,
        (neck * 1.1, top + 0.01),
        (neck * 1.1, top + 0.03),
        (neck * 1.02, top + 0.04),
        (neck * 1.02, top + 0.3 * (height - top)),
        (neck * 1.4, height - 0.35 * (height - top)),
    ]
    plinth = box((-1.4 * r, -1.4 * r, -0.04), (1.4 * r, 1.4 * r, 0.03))
    wide = neck * 1.5
    abacus = box((-wide, -wide, height - 0.35 * (height - top)), (wide, wide, height))
    return join([plinth, lathe(profile, sides), abacus])


def balustrade(length: Number, height: Number = 0.55) -> Mesh:
    """Turned balusters between two rails, along x from the origin."""
    h = height
    profile = [
        (0.05, 0.07),
        (0.05, 0.12),
        (0.025, 0.16),
        (0.065, 0.4 * h),
        (0.03, 0.68 * h),
        (0.05, 0.8 * h),
        (0.05, h - 0.08),
    ]
    baluster = lathe(profile, 8)
    count = max(int(length / 0.19), 2)
    rails = [
        box((0, -0.08, 0), (length, 0.08, 0.07)),
        box((0, -0.1, h - 0.08), (length, 0.1, h)),
        box((-0.1, -0.11, 0), (0.1, 0.11, h + 0.04)),
        box((length - 0.1, -0.11, 0), (length + 0.1, 0.11, h + 0.04)),
    ]
    places = (np.arange(count) + 0.5) * length / count
    return join([*rails, *(baluster.placed(0.0, (x, 0, 0)) for x in places)])


def pediment(width: Number, height: Number, depth: Number, relief: Number = 0.14) -> Mesh:
    """A triangular gable over a span along x from the origin, with raised raking cornices."""
    slope = degrees(atan2(height, width / 2))
    length = hypot(height, width / 2)
    tympanum = prism([(0.1, 0.0), (width - 0.1, 0.0), (width / 2, height - 0.06)], 0.0, depth)
    rake = box((-0.1, -relief, -0.05), (length + 0.04, depth, 0.11))
    fillet = box((-0.1, -relief - 0.05, 0.06), (length + 0.04, depth, 0.15))
    left = _pitched(join([rake, fillet]), slope)
    right = _mirrored(left, width)
    floor = box((-0.1, -relief, -0.06), (width + 0.1, depth, 0.06))
    return join([tympanum, left, right, floor])


def _pitched(mesh: Mesh, angle_deg: Number) -> Mesh:
    """Turn about the y axis so that +x rises."""
    c, s = cos(radians(angle_deg)), sin(radians(angle_deg))
    turn = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    return Mesh(mesh.vertices @ turn.T, mesh.normals @ turn.T, mesh.uvs, mesh.faces)


def _mirrored(mesh: Mesh, width: Number) -> Mesh:
    """Reflect in the plane x = width / 2."""
    flip = np.array([-1.0, 1.0, 1.0])
    moved = mesh.vertices * flip + np.array([width, 0.0, 0.0])
    return Mesh(moved, mesh.normals * flip, mesh.uvs, mesh.faces[:, ::-1].copy())


def tiled_slope(eaves: Number, run: Number, rise: Number, courses: int) -> Mesh:
    """One roof slope: courses of overlapping tiles, eaves along x at the origin, rising into +y."""
    faces = []
    thick = 0.045
    for i in range(courses):
        y0, y1 = run * i / courses, run * (i + 1) / courses
        z0, z1 = rise * i / courses + thick, rise * (i + 1) / courses
        faces.append(polygon([(0, y0, z0), (eaves, y0, z0), (eaves, y1, z1), (0, y1, z1)]))
        low = z0 - thick
        faces.append(polygon([(0, y0, low), (eaves, y0, low), (eaves, y0, z0), (0, y0, z0)]))
    return join(faces)


def gable_roof(low: Vector, high: Vector, rise: Number, overhang: Number, courses: int) -> Mesh:
    """Two tiled slopes over a rectangle, the ridge along y, with verge boards; eaves at z = 0."""
    (x0, y0), (x1, y1) = low, high
    half = (x1 - x0) / 2
    drop = overhang * rise / half
    length = y1 - y0 + 2 * overhang
    slope = tiled_slope(length, half + overhang, rise + drop, courses)
    left = slope.placed(-90.0, (x0 - overhang, y1 + overhang, -drop))
    right = slope.placed(90.0, (x1 + overhang, y0 - overhang, -drop))
    ridge = lathe([(0.09, 0.0), (0.09, length)], 10)
    turned = ridge.vertices[:, [0, 2, 1]] * np.array([1.0, 1.0, -1.0])
    normals = ridge.normals[:, [0, 2, 1]] * np.array([1.0, 1.0, -1.0])
    offset = np.array([(x0 + x1) / 2, y0 - overhang, rise + 0.03])
    cap = Mesh(turned + offset, normals, ridge.uvs, ridge.faces)
    return join([left, right, cap])


def pyramid(low: Vector, high: Vector, height: Number, courses: int) -> Mesh:
    """A stepped-tile pyramid roof over a rectangle, eaves at z = 0, closed below."""
    (x0, y0), (x1, y1) = low, high
    half = min(x1 - x0, y1 - y0) / 2
    profile = []
    for i in range(courses):
        f, g = i / courses, (i + 1) / courses
        profile += [(-half * f, height * f), (-half * f, height * f + 0.035)]
        profile += [(-half * g + (0.0 if g < 1 else 1e-4), height * g)]
    base = polygon([(x0, y0, 0), (x0, y1, 0), (x1, y1, 0), (x1, y0, 0)])
    return join([moulding(low, high, profile), base])


def steps(low: Vector, high: Vector, count: int, rise: Number, tread: Number) -> Mesh:
    """A flight of steps on all sides of a rectangle; its top has the rectangle's size."""
    profile = []
    for i in range(count):
        offset = (count - 1 - i) * tread
        profile += [(offset, i * rise), (offset, (i + 1) * rise)]
    return moulding(low, high, profile)


def urn(height: Number) -> Mesh:
    """A garden urn on a pedestal, its foot at the origin."""
    h = height
    profile = [(0.1, 0.5), (0.05, 0.56), (0.05, 0.6), (0.2, 0.74), (0.22, 0.85), (0.17, 0.92)]
    bowl = lathe(
        [(r * h, z * h) for r, z in [*profile, (0.23, 0.96), (0.24, 1.0), (0.0, 0.97)]], 16
    )
    shape = [(0.03, 0.0), (0.03, 0.07), (0.0, 0.1), (0.0, 0.42), (0.03, 0.45), (0.03, 0.5)]
    side = 0.14 * h
    foot = moulding((-side, -side), (side, side), [(o, z * h) for o, z in shape])
    return join([foot, bowl])


def lamp(height: Number) -> list[Part]:
    """A cast-iron street lamp, its foot at the origin."""
    pole = lathe([(0.1, 0), (0.1, 0.2), (0.05, 0.3), (0.035, height), (0.07, height + 0.03)], 10)
    cage = lathe([(0.09, height + 0.03), (0.15, height + 0.33)], 6, smooth=False)
    hood = lathe([(0.17, height + 0.33), (0.05, height + 0.48), (0.0, height + 0.56)], 6)
    return [("metal", join([pole, hood])), ("glass", cage)]


def chimney(x: Number, y: Number, z: Number, height: Number) -> Mesh:
    """A chimney with a moulded head and two pots."""
    stack = moulding((x - 0.3, y - 0.2), (x + 0.3, y + 0.2), [(0, z), (0, z + height)])
    head = moulding(
        (x - 0.3, y - 0.2),
        (x + 0.3, y + 0.2),
        [(0, z + height - 0.2), (0.07, z + height - 0.16), (0.07, z + height)],
    )
    pots = [
        lathe([(0.09, 0), (0.075, 0.25), (0.095, 0.3), (0.0, 0.29)], 10).placed(
            0, (x + dx, y, z + height)
        )
        for dx in (-0.14, 0.14)
    ]
    return join([stack, head, *pots])
