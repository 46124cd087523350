"""Meshes against closed forms: volumes by the divergence theorem, areas, normals, winding."""

from itertools import chain

import numpy as np
import pytest

from r3gw.benchmark.generate import PLACES
from r3gw.benchmark.meshes import Mesh, box, lathe, moulding, polygon, prism
from r3gw.benchmark.ornaments import pyramid, tiled_slope
from r3gw.benchmark.seeds import stream
from r3gw.benchmark.walls import ARC_SEGMENTS, Opening, wall


def area_vectors(mesh: Mesh) -> np.ndarray:
    """Area times normal of each triangle, from the winding alone."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a) / 2


def volume(mesh: Mesh) -> float:
    """Enclosed volume; negative if faces look inwards."""
    corner = mesh.vertices[mesh.faces[:, 0]]
    return float((corner * area_vectors(mesh)).sum() / 3)


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (box((-1, 2, 0.5), (1, 5, 1.5)), 6.0),
        (prism([(0, 0), (3, 0), (0, 2)], -1, 1), 6.0),
        (lathe([(0, 0), (2, 0), (2, 1), (0, 1)], 400), 4 * np.pi),
        (lathe([(0, 0), (3, 0), (0, 4)], 400, smooth=False), 12 * np.pi),
        (moulding((0, 0), (2, 3), [(-1, 0), (1, 0), (1, 2)]), 40.0),
    ],
)
def test_solids_enclose_their_volume_and_face_outwards(mesh: Mesh, expected: float) -> None:
    assert volume(mesh) == pytest.approx(expected, rel=1e-3, abs=1e-6)


def test_a_turn_is_counter_clockwise_seen_from_above() -> None:
    corner = box((1, 0, 0), (1, 0, 0)).placed(90, (0, 0, 5)).vertices[0]
    np.testing.assert_allclose(corner, [0, 1, 5], rtol=0, atol=1e-12)


@pytest.mark.parametrize("is_arched", [False, True])
def test_a_wall_loses_its_openings_and_gains_their_reveals(is_arched: bool) -> None:
    opening = Opening(1.0, 2.0, 0.5, 2.0, is_arched, depth=0.3)
    vectors = area_vectors(wall(4.0, 3.0, [opening]))
    # An arch of n chords: n triangles of apex angle pi/n under radius 1/2, sides 0.5 * 2 sin.
    step = np.pi / ARC_SEGMENTS
    arch = ARC_SEGMENTS * 0.5**2 * np.sin(step) / 2
    hole = 1.0 + arch if is_arched else 1.5
    girth = 1 + 2 * 1.0 + ARC_SEGMENTS * np.sin(step / 2) if is_arched else 5.0
    is_front = vectors[:, 1] < -1e-9
    assert -vectors[is_front, 1].sum() == pytest.approx(12 - hole, rel=1e-9)
    assert np.linalg.norm(vectors[~is_front], axis=1).sum() == pytest.approx(0.3 * girth, rel=1e-9)


def test_reveals_face_into_the_hole() -> None:
    mesh = wall(4.0, 3.0, [Opening(1.0, 2.0, 0.5, 2.0)])
    centre = np.array([1.5, 0.11, 1.25])
    vectors = area_vectors(mesh)
    inner = np.abs(vectors[:, 1]) < 1e-9
    towards = centre - mesh.vertices[mesh.faces].mean(axis=1)
    assert ((vectors * towards).sum(axis=1)[inner] > 0).all()


def test_roofs_look_up() -> None:
    for roof in (tiled_slope(4, 2, 1, 8), pyramid((0, 0), (2, 2), 1.5, 6)):
        assert area_vectors(roof)[:, 2].sum() >= -1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", PLACES)
def test_every_part_of_a_place_is_sound(name: str) -> None:
    parts, materials = PLACES[name].build(stream(0, name, "build"))
    assert {part for part, _ in parts} <= set(materials)
    for material, mesh in parts:
        assert np.isfinite(mesh.vertices).all(), material
        vectors = area_vectors(mesh)
        is_big = np.linalg.norm(vectors, axis=1) > 1e-7
        normals = mesh.normals[mesh.faces].mean(axis=1)
        cosine = (vectors * normals).sum(axis=1)[is_big]
        assert (cosine > 0).all(), f"{name}: {material} has faces wound against their normals"
        used = mesh.normals[np.unique(mesh.faces[is_big])]
        np.testing.assert_allclose(np.linalg.norm(used, axis=1), 1.0, rtol=0, atol=1e-9)
    heights = np.concatenate([mesh.vertices[:, 2] for _, mesh in parts])
    assert heights.min() > -0.4
    assert 6.0 < heights.max() < 10.0


def test_a_flat_polygon_measures_its_texture_in_lengths() -> None:
    roof = polygon([(0, 0, 0), (2, 0, 0), (2, 3, 4), (0, 3, 4)])
    pairs = chain(zip(roof.vertices[:-1], roof.vertices[1:], strict=True))
    lengths = [np.linalg.norm(b - a) for a, b in pairs]
    measured = np.linalg.norm(np.diff(roof.uvs, axis=0), axis=1)
    np.testing.assert_allclose(measured, lengths, rtol=1e-12, atol=0)
