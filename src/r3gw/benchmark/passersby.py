"""Transient occluders: people and parked cars, made of simple shapes. Feet at z = 0."""

import numpy as np

from r3gw.benchmark.materials import Kind, Material
from r3gw.benchmark.meshes import Mesh, Part, box, join, lathe, prism

CLOTHES = ("coat", "jeans", "shirt")


def materials(random: np.random.Generator) -> dict[str, Material]:
    """Colours of one photo's passers-by."""
    kind = Kind.OCCLUDER

    def colour(low: float, high: float) -> tuple[float, float, float]:
        grey = random.uniform(low, high)
        red, green, blue = grey * random.uniform(0.6, 1.2, 3)  # Muted, as most clothes and cars
        return float(red), float(green), float(blue)

    clothes = {name: Material(colour(0.04, 0.5), kind=kind) for name in CLOTHES}
    return clothes | {
        "skin": Material((0.45, 0.28, 0.2), kind=kind),
        "hair": Material((0.05, 0.03, 0.02), kind=kind),
        "paint": Material(colour(0.05, 0.6), roughness=0.25, kind=kind),
        "screen": Material((0.03, 0.03, 0.04), roughness=0.2, kind=kind),
        "tyre": Material((0.03, 0.03, 0.03), kind=kind),
    }


def person(random: np.random.Generator) -> list[Part]:
    """A standing person about 1.15 units tall."""
    height = random.uniform(1.05, 1.22)
    legs = [
        lathe([(0.055, 0), (0.06, 0.25), (0.08, 0.5)], 10).placed(0.0, (dx, dy, 0))
        for dx, dy in ((-0.07, 0.04), (0.07, -0.05))
    ]
    torso = lathe([(0.13, 0.45), (0.14, 0.55), (0.13, 0.7), (0.16, 0.85), (0.08, 0.95)], 12)
    arms = [
        lathe([(0.035, 0.47), (0.05, 0.65), (0.055, 0.88)], 8).placed(0.0, (dx, 0, 0))
        for dx in (-0.2, 0.2)
    ]
    turn = np.linspace(-np.pi / 2, np.pi / 2, 9)
    ball = np.stack([0.085 * np.cos(turn), 1.04 + 0.105 * np.sin(turn)], axis=1)
    cap = lathe(ball[5:] * [1.08, 1.0] + [0.0, 0.012], 12)
    top, bottom = random.permutation(CLOTHES)[:2]
    parts = [
        (str(bottom), join(legs)),
        (str(top), join([torso, *arms])),
        ("skin", lathe(ball, 12)),
        ("hair", cap),
    ]
    return [(material, _scaled(mesh, height / 1.15)) for material, mesh in parts]


def _scaled(mesh: Mesh, factor: float) -> Mesh:
    return Mesh(mesh.vertices * factor, mesh.normals, mesh.uvs, mesh.faces)


def car() -> list[Part]:
    """A small car, 2.8 units long, along x."""
    body = prism(
        [(-1.4, 0.2), (1.4, 0.2), (1.42, 0.45), (1.3, 0.6), (-1.3, 0.62), (-1.42, 0.5)], 0, 1.2
    )
    cabin = prism([(-1.0, 0.6), (0.75, 0.6), (0.3, 0.98), (-0.75, 0.98)], 0.08, 1.12)
    roof = prism([(-0.78, 0.96), (0.34, 0.96), (0.24, 1.02), (-0.68, 1.02)], 0.06, 1.14)
    pillars = [box((x - 0.03, 0.06, 0.6), (x + 0.03, 1.14, 0.98)) for x in (-0.72, -0.15, 0.3)]
    wheel = lathe([(0.0, 0.0), (0.22, 0.0), (0.24, 0.03), (0.24, 0.17), (0.0, 0.17)], 18)
    turned = Mesh(
        wheel.vertices[:, [0, 2, 1]] * [1, 1, -1],
        wheel.normals[:, [0, 2, 1]] * [1, 1, -1],
        wheel.uvs,
        wheel.faces,
    )
    wheels = [turned.placed(0.0, (x, y, 0.24)) for x in (-0.9, 0.9) for y in (-0.03, 1.06)]
    return [
        ("paint", join([body, roof, *pillars])),
        ("screen", cabin),
        ("tyre", join(wheels)),
    ]
