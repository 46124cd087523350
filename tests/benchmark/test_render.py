"""Rendered ground truth against rays cut with a cylinder and planes by hand."""

import numpy as np
import pytest
import torch

from r3gw.benchmark import render
from r3gw.benchmark.materials import Kind, Material
from r3gw.benchmark.meshes import box, lathe, polygon
from r3gw.geometry.cameras import Camera, pixel_rays

GREY = np.full((8, 16, 3), 1.0)
# At the height of 1 (world y = -1), 6 units in front of the origin, looking along +z; the
# principal point is off the middle.
POSE = np.array([[1.0, 0, 0, 0], [0, 1, 0, 1], [0, 0, 1, 6], [0, 0, 0, 1]])
CAMERA = Camera(torch.from_numpy(POSE), (70.0, 70.0, 37.4, 26.0), 64, 48)


def test_a_cylinder_has_the_depth_and_normals_of_ray_geometry() -> None:
    solids = render.shapes(
        [("pole", lathe([(1.5, 0.0), (1.5, 3.0)], 256))], {"pole": Material((0.5, 0.4, 0.3))}
    )
    seen = render.truth(render.scene(render.emitter(GREY), solids), CAMERA, [Kind.BUILDING])
    rays = pixel_rays(CAMERA).numpy().astype(float)
    x, y = rays[..., 0], rays[..., 1]
    # |(t x, t - 6)| = 1.5 in the level plane, t = camera z as rays have z = 1.
    a, b, c = x**2 + 1, -6.0, 36 - 1.5**2
    root = b**2 - a * c
    depth = (-b - np.sqrt(np.maximum(root, 0))) / a
    level = depth * y - 1  # World y; the pole spans -3 to 0
    is_inside = (root > 0.3) & (level < -0.05) & (level > -2.95)
    assert is_inside.sum() > 300
    np.testing.assert_allclose(seen.depth[is_inside], depth[is_inside], rtol=1e-3, atol=0)
    normal = np.stack([depth * x, np.zeros_like(x), depth - 6], axis=-1) / 1.5
    np.testing.assert_allclose(seen.normal[is_inside], normal[is_inside], rtol=0, atol=5e-3)
    np.testing.assert_allclose(
        seen.albedo[is_inside], np.tile([0.5, 0.4, 0.3], (is_inside.sum(), 1)), rtol=1e-5, atol=0
    )
    is_sky = root < -0.3
    assert (seen.depth[is_sky] == 0).all()
    assert (seen.kind[is_sky] == -1).all()
    assert (seen.kind[is_inside] == render.KINDS.index(Kind.BUILDING)).all()


def test_albedo_is_the_mean_over_a_pixel_and_geometry_its_centre() -> None:
    """Two sheets at z = 0 that meet at x = 0 (the middle of pixel 37): dark left, light right."""
    sheets = [
        ("dark", polygon([(-9, 0, -9), (0, 0, -9), (0, 0, 9), (-9, 0, 9)])),
        ("light", polygon([(0, 0, -9), (9, 0, -9), (9, 0, 9), (0, 0, 9)])),
    ]
    materials = {"dark": Material((0.2, 0.2, 0.2)), "light": Material((0.8, 0.8, 0.8))}
    place = render.scene(render.emitter(GREY), render.shapes(sheets, materials))
    seen = render.truth(place, CAMERA, [Kind.BUILDING, Kind.GROUND])
    np.testing.assert_allclose(seen.albedo[10, 36:39, 0], [0.2, 0.5, 0.8], rtol=1e-5, atol=0)
    np.testing.assert_allclose(seen.depth, 6.0, rtol=1e-5, atol=0)


def test_a_white_sky_makes_a_matte_wall_as_bright_as_its_albedo() -> None:
    wall = [("wall", polygon([(-9, 0, -9), (9, 0, -9), (9, 0, 9), (-9, 0, 9)]))]
    solids = render.shapes(wall, {"wall": Material((0.6, 0.3, 0.1))})
    image = render.photo(render.scene(render.emitter(GREY), solids), CAMERA, 16, 5)
    np.testing.assert_allclose(image.mean(axis=(0, 1)), [0.6, 0.3, 0.1], rtol=0.01, atol=0)


@pytest.mark.parametrize(("wanted", "expected"), [(Kind.OCCLUDER, True), (Kind.GROUND, False)])
def test_masks_tell_kinds_apart(wanted: Kind, expected: bool) -> None:
    parts = [
        ("box", box((-0.5, -0.5, 0.5), (0.5, 0.5, 1.5))),
        ("floor", box((9, 9, 0), (10, 10, 1))),
    ]
    materials = {name: Material((0.5, 0.5, 0.5)) for name, _ in parts}
    place = render.scene(render.emitter(GREY), render.shapes(parts, materials))
    hit = render.touches(place, CAMERA, [Kind.OCCLUDER, Kind.GROUND], wanted)
    # The front face, at depth 5.5, spans 70 / 5.5 = 12.7 px about the principal point.
    assert hit[26, 37] == expected
    columns = np.flatnonzero(hit[26])
    if expected:
        assert columns[0] == pytest.approx(37.4 - 6.36, abs=1)
        assert columns[-1] + 1 == pytest.approx(37.4 + 6.36, abs=1)
