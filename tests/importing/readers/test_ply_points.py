"""Colours of point clouds in the types that programs write."""

import numpy as np
import plyfile
import pytest

from r3gw.files import InputError
from r3gw.importing.readers.ply_points import read_ply_points

XYZ = np.array([[482000.25, 5400000.5, 12.0], [0.0, -1.0, 2.0]])
RGB = np.array([[255, 0, 51], [102, 204, 255]], np.uint8)


def write(path, colours, kind, names=("red", "green", "blue"), xyz_kind="f8"):
    fields = [(name, xyz_kind) for name in "xyz"] + [(name, kind) for name in names]
    rows = np.array([tuple(p) + tuple(c) for p, c in zip(XYZ, colours, strict=True)], fields)
    plyfile.PlyData([plyfile.PlyElement.describe(rows, "vertex")]).write(str(path))
    return path


@pytest.mark.parametrize(
    ("colours", "kind", "names"),
    [
        (RGB, "u1", ("red", "green", "blue")),
        (RGB, "u1", ("diffuse_red", "diffuse_green", "diffuse_blue")),
        (RGB / 255.0, "f4", ("red", "green", "blue")),
        (RGB / 255.0, "f8", ("r", "g", "b")),
        (RGB.astype(float), "f4", ("red", "green", "blue")),
        (RGB.astype(int) * 257, "u2", ("red", "green", "blue")),
        (RGB, "i4", ("red", "green", "blue")),
    ],
)
def test_colours(tmp_path, colours, kind, names):
    points = read_ply_points(write(tmp_path / "a.ply", colours, kind, names))
    assert np.array_equal(points.rgb, RGB)
    assert np.array_equal(points.xyz, XYZ)  # in double precision


def test_the_constant_harmonic_of_splats_is_their_colour(tmp_path):
    """Y_0 is 1 / (2 sqrt(pi)): colour = 0.5 + Y_0 f_dc, so f_dc = (colour - 0.5) 2 sqrt(pi)."""
    names = ("f_dc_0", "f_dc_1", "f_dc_2")
    constant = (RGB / 255.0 - 0.5) * 2.0 * np.sqrt(np.pi)
    points = read_ply_points(write(tmp_path / "a.ply", constant, "f4", names))
    assert np.array_equal(points.rgb, RGB)


def test_names_in_upper_case(tmp_path):
    path = write(tmp_path / "a.ply", RGB, "u1", ("Red", "Green", "Blue"))
    data = path.read_bytes()
    for axis in (b"x", b"y", b"z"):
        data = data.replace(b"double " + axis + b"\n", b"double " + axis.upper() + b"\n")
    path.write_bytes(data)
    points = read_ply_points(path)
    assert np.array_equal(points.rgb, RGB)
    assert np.array_equal(points.xyz, XYZ)


def test_points_without_colour_are_black_and_without_place_refused(tmp_path):
    points = read_ply_points(write(tmp_path / "a.ply", RGB, "u1", ("nx", "ny", "nz")))
    assert not points.rgb.any()
    path = write(tmp_path / "b.ply", RGB, "u1")
    path.write_bytes(path.read_bytes().replace(b" z\n", b" w\n"))
    with pytest.raises(InputError, match=r"have no x, y and z \(x, y, w, red, green, blue\)"):
        read_ply_points(path)
    nowhere = np.array([(np.nan, 0.0, 0.0)], [("x", "f4"), ("y", "f4"), ("z", "f4")])
    element = plyfile.PlyElement.describe(nowhere, "vertex")
    plyfile.PlyData([element]).write(str(tmp_path / "c.ply"))
    with pytest.raises(InputError, match=r"holds points at NaN"):
        read_ply_points(tmp_path / "c.ply")
