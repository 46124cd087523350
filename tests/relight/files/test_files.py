"""r3gw.relight: PLY and lights.json read by hand, round trips, other coordinates."""

import json
from dataclasses import fields, replace
from math import log

import numpy as np
import pytest
import torch

from r3gw.files import InputError
from r3gw.geometry.rotations import rotation_from_quaternion
from r3gw.geometry.similarity import Similarity
from r3gw.lighting import sh
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.relight.files.lights_file import read_lights, write_lights
from r3gw.relight.files.ply import Baked, Placement, read_ply, write_ply
from r3gw.relight.gaussians import Relightable, relightable_of
from r3gw.relight.load import load_relightable
from r3gw.relight.move import moved

STANDARD = (
    *("x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity"),
    *("scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"),
)
HERE = Placement("scene", Similarity.identity())
# Half as large, a quarter turn about y (+z to +x), then shifted.
SOURCE_FROM_SCENE = Similarity(
    0.5,
    torch.tensor([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]], dtype=torch.float64),
    torch.tensor([10.0, -4.0, 1.0], dtype=torch.float64),
)


def two() -> Relightable:
    """One foreground Gaussian and one of the sky, with values to check by hand."""
    return Relightable(
        torch.tensor([[1.0, 2.0, 3.0], [0.0, -9.0, 0.5]]),
        torch.tensor([[2.0, 0.0, 0.0, 2.0], [1.0, 0.0, 0.0, 0.0]]),
        torch.tensor([[-1.0, -2.0, -27.5], [0.0, 0.1, 0.2]]),
        torch.tensor([0.0, 3.0]),
        torch.tensor([[0.1, 0.2, 0.3]]),
        torch.tensor([0.7]),
        {"p": Light(torch.arange(75.0).reshape(25, 3) / 7, LearnedSky(torch.full((4, 3), 1 / 3)))},
        4,
        True,
        torch.arange(25.0)[None] / 64,
    )


def baked() -> Baked:
    return Baked(
        torch.tensor([[0.5, 1.0, 0.0], [0.78209479, 0.25, 0.75]]),
        torch.tensor([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0]]),
    )


def by_hand(path) -> tuple[list[str], dict[str, np.ndarray]]:
    """Header lines and columns, without any PLY library."""
    head, data = path.read_bytes().split(b"end_header\n", 1)
    lines = head.decode("ascii").splitlines()
    kinds = {"float": "<f4", "uchar": "u1"}
    named = [line.split()[1:] for line in lines if line.startswith("property")]
    rows = np.frombuffer(data, [(name, kinds[kind]) for kind, name in named])
    return lines, {name: rows[name] for _, name in named}


def test_standard_file_by_hand(tmp_path):
    write_ply(tmp_path / "a.ply", two(), baked(), HERE, relightable=False)
    lines, columns = by_hand(tmp_path / "a.ply")
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    assert "element vertex 2" in lines
    assert [line for line in lines if line.startswith("property")] == [
        f"property float {name}" for name in STANDARD
    ]
    first = [float(columns[name][0]) for name in STANDARD]
    # f_dc = (0.5, 1, 0) minus 0.5, over 0.28209479
    expected = [1, 2, 3, 0, 0, -1, 0, 1.7724539, -1.7724539, 0, -1, -2, -27.5, 2, 0, 0, 2]
    np.testing.assert_allclose(first, expected, rtol=1e-6, atol=1e-7)
    second = [float(columns[f"f_dc_{i}"][1]) for i in range(3)]
    np.testing.assert_allclose(second, [1.0, -0.8862269, 0.8862269], rtol=1e-6, atol=1e-7)
    assert columns["opacity"][1] == 3.0


def test_relightable_file_adds_properties_at_the_end(tmp_path):
    write_ply(tmp_path / "a.ply", two(), baked(), HERE, relightable=True)
    _, columns = by_hand(tmp_path / "a.ply")
    own = ["albedo_0", "albedo_1", "albedo_2", "roughness", "is_sky"]
    assert list(columns) == [*STANDARD, *own, *(f"occlusion_{i}" for i in range(25))]
    assert columns["occlusion_24"].tolist() == [0.375, 0.0]
    assert columns["albedo_1"].tolist() == [np.float32(0.2), 0.0]
    assert columns["roughness"].tolist() == [np.float32(0.7), 0.0]
    assert columns["is_sky"].tolist() == [0, 1]


def assert_equal(found: Relightable, expected: Relightable, **tolerance) -> None:
    for field in fields(Relightable):
        ours, theirs = getattr(found, field.name), getattr(expected, field.name)
        if theirs is None:
            assert ours is None
        elif field.name == "lights":
            assert list(ours) == list(theirs)
            for photo in theirs:
                a, b = ours[photo], theirs[photo]
                torch.testing.assert_close(a.sh, b.sh, **tolerance)
                torch.testing.assert_close(a.sky_coefficients, b.sky_coefficients, **tolerance)
        elif field.name == "origin":
            assert ours.endswith("a.ply")
        else:
            torch.testing.assert_close(ours, theirs, **tolerance)


def test_a_trained_model_comes_back_bit_for_bit(tiny, tmp_path):
    model = relightable_of(tiny.model)
    colours = Baked(torch.rand(len(model.means), 3), torch.zeros(len(model.means), 3))
    write_ply(tmp_path / "a.ply", model, colours, HERE, relightable=True)
    write_lights(model.lights, "scene", tmp_path)
    assert_equal(load_relightable(tmp_path / "a.ply"), model, rtol=0, atol=0)


def test_source_coordinates_and_back(tmp_path):
    there = moved(two(), SOURCE_FROM_SCENE)
    # x' = z / 2 + 10, y' = y / 2 - 4, z' = -x / 2 + 1
    expected = torch.tensor([[11.5, -3.0, 0.5], [10.25, -8.5, 1.0]])
    torch.testing.assert_close(there.means, expected, rtol=1e-6, atol=1e-6)
    torch.testing.assert_close(there.log_scales, two().log_scales + log(0.5), rtol=1e-6, atol=0)
    rotation = SOURCE_FROM_SCENE.rotation.float()
    for before, after in zip(axes(two()), axes(there), strict=True):
        covariance = 0.25 * rotation @ before @ before.T @ rotation.T
        torch.testing.assert_close(after @ after.T, covariance, rtol=1e-5, atol=1e-6)
    # A light from +z in the scene comes from +x in the source.
    looks = torch.nn.functional.normalize(torch.randn(50, 3), dim=-1)
    light, turned = two().lights["p"].sh, there.lights["p"].sh
    torch.testing.assert_close(
        sh.radiance(turned, looks @ rotation.T), sh.radiance(light, looks), rtol=1e-4, atol=1e-4
    )
    # What a light loses to shadows does not depend on the coordinates.
    for splats, shone in ((two(), light), (there, turned)):
        torch.testing.assert_close(splats.occlusion @ shone, two().occlusion @ light)
    placement = Placement("source", SOURCE_FROM_SCENE.inverse())
    write_ply(tmp_path / "a.ply", there, baked(), placement, relightable=True)
    write_lights(there.lights, "source", tmp_path)
    found = read_ply(tmp_path / "a.ply")
    torch.testing.assert_close(axes(found), axes(two()), rtol=1e-5, atol=1e-5)
    same = {"quaternions": two().quaternions}  # compared as axes: they may come back shorter
    assert_equal(replace(found, **same), two(), rtol=1e-5, atol=1e-5)


def axes(splats: Relightable) -> torch.Tensor:
    """Rotation times scales, ``[N, 3, 3]``."""
    return rotation_from_quaternion(splats.quaternions) * splats.scales[:, None, :]


def test_lights_file_says_what_it_holds(tmp_path):
    lights = two().lights
    write_lights(lights, "scene", tmp_path)
    content = json.loads((tmp_path / "lights.json").read_text())
    assert content["coordinates"] == "scene"
    assert "Condon" in content["convention"]["basis"]
    entry = content["photos"]["p"]
    assert (len(entry["light"]), len(entry["sky"])) == (25, 4)
    # Degree 1 as the file describes it: 0.488603 times y, z, x of coefficients 1, 2, 3.
    towards = np.array([0.36, -0.48, 0.8])
    basis = np.array([0.282095, *0.488603 * towards[[1, 2, 0]]])
    ours = sh.radiance(lights["p"].sky_coefficients, torch.tensor(towards, dtype=torch.float32))
    np.testing.assert_allclose(basis @ np.array(entry["sky"]), ours.numpy(), rtol=1e-5, atol=0)
    assert (read_lights(tmp_path)["p"].sh == lights["p"].sh).all()
    assert read_lights(tmp_path / "elsewhere") == {}


def test_files_that_are_none_of_ours_are_told(tmp_path):
    with pytest.raises(InputError, match="no such file; export"):
        read_ply(tmp_path / "none.ply")
    (tmp_path / "text.ply").write_text("hello")
    with pytest.raises(InputError, match="not a PLY file"):
        read_ply(tmp_path / "text.ply")
    write_ply(tmp_path / "plain.ply", two(), baked(), HERE, relightable=False)
    with pytest.raises(InputError, match=r"relightable\.ply"):
        read_ply(tmp_path / "plain.ply")
    write_ply(tmp_path / "good.ply", two(), baked(), HERE, relightable=True)
    (tmp_path / "lights.json").write_text('{"coordinates": "scene", "fotos": {}}')
    with pytest.raises(InputError, match="fotos"):
        read_ply(tmp_path / "good.ply")


def retold(data: bytes, change) -> bytes:
    """A PLY file with another header."""
    header, end, rows = data.partition(b"end_header\n")
    return change(header + end) + rows


@pytest.mark.parametrize(
    "change",
    [
        lambda head: head.replace(b"element", b"comment made by a viewer\nelement"),
        lambda head: head.replace(b"element", b"obj_info num_cols 1\nelement"),
        lambda head: head.replace(b"\n", b"\r\n"),
        lambda head: head.replace(b" float ", b" float32 ").replace(b" uchar ", b" uint8 "),
    ],
)
def test_other_programs_headers_change_nothing(tmp_path, change):
    path = tmp_path / "a.ply"
    write_ply(path, two(), baked(), HERE, relightable=True)
    expected = read_ply(path)
    path.write_bytes(retold(path.read_bytes(), change))
    found = read_ply(path)
    for field in fields(Relightable):
        value = getattr(found, field.name)
        if isinstance(value, torch.Tensor):
            assert torch.equal(value, getattr(expected, field.name))


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (b"comment r3gw light_degree 4\n", b"", r"key 'light_degree' is missing"),
        (b"light_degree 4", b'light_degree "four"', r"key 'light_degree' has the value 'four'"),
        (b"light_degree 4", b"light_degree {4", r"not a PLY file of Gaussians"),
        (b"comment r3gw", b"comment not", r"lacks r3gw's comments in the header"),
        (b"float albedo_1", b"float albedo_x", r"lacks r3gw's property albedo_1"),
        (b"float rot_3", b"float rot_4", r"lacks r3gw's property rot_3"),
    ],
)
def test_damaged_headers_are_refused(tmp_path, old, new, sentence):
    path = tmp_path / "a.ply"
    write_ply(path, two(), baked(), HERE, relightable=True)
    path.write_bytes(retold(path.read_bytes(), lambda head: head.replace(old, new)))
    with pytest.raises(InputError, match=sentence):
        read_ply(path)


def test_values_that_are_no_numbers_are_refused(tmp_path):
    gaussians = replace(two(), means=torch.tensor([[1.0, float("nan"), 3.0], [0.0, -9.0, 0.5]]))
    write_ply(tmp_path / "a.ply", gaussians, baked(), HERE, relightable=True)
    with pytest.raises(InputError, match="holds NaN or infinite values; export the scene again"):
        read_ply(tmp_path / "a.ply")
