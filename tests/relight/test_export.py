"""Exports: baked colours against pictures, the glTF container read by hand, round trips."""

import json
import struct

import numpy as np
import plyfile
import pytest
import torch

from r3gw.files import InputError, write_json
from r3gw.geometry.similarity import Similarity
from r3gw.imaging.files import read_rgb
from r3gw.raster import rasterize
from r3gw.relight.cameras import CameraOptions
from r3gw.relight.export import export
from r3gw.relight.film import relight
from r3gw.relight.gaussians import relightable_of
from r3gw.relight.lights import LightOptions, PhotoSource, still_light
from r3gw.relight.picture import frame
from r3gw.relight.sweep import Sweep
from r3gw.relight.tone import standard
from r3gw.relight.trained import load
from r3gw.scene import load_scene, save_scene
from r3gw.scene.scene import Gauge

A_0 = LightOptions(PhotoSource(("a_0",)))
NAMES = ["baked.glb", "baked.ply", "lights.json", "relightable.ply"]


def exported_to(model_path, scene_folder, target, light: LightOptions, **options) -> None:
    """An export from files, as the command line makes it."""
    trained = load(model_path, scene_folder)
    export(trained, target, still_light(trained.gaussians, light), **options)


def opened(path) -> dict[str, torch.Tensor]:
    """What a viewer makes of a PLY file: activated values, by the format's own rules."""
    rows = plyfile.PlyData.read(str(path))["vertex"].data

    def columns(*names: str) -> torch.Tensor:
        return torch.from_numpy(np.stack([rows[name] for name in names], axis=-1).copy())

    return {
        "means": columns("x", "y", "z"),
        "quaternions": columns("rot_0", "rot_1", "rot_2", "rot_3"),
        "scales": columns("scale_0", "scale_1", "scale_2").exp(),
        "opacities": columns("opacity")[:, 0].sigmoid(),
        "features": 0.28209479 * columns("f_dc_0", "f_dc_1", "f_dc_2") + 0.5,
    }


def seen(parts: dict[str, torch.Tensor], camera) -> torch.Tensor:
    """A viewer's picture on black, with alpha as its fourth channel."""
    result = rasterize(
        **parts, cam_from_world=camera.cam_from_world.float(), intrinsics=camera.intrinsics,
        width=camera.width, height=camera.height,
    )  # fmt: skip
    return torch.cat([result.features, result.alpha[..., None]], dim=-1)


@pytest.fixture(scope="module")
def exported(tiny, tmp_path_factory):
    """An export baked for the camera of b_exact."""
    target = tmp_path_factory.mktemp("export")
    exported_to(tiny.model_path, tiny.folder, target, A_0, view="b_exact")
    return target


def test_files(exported):
    assert sorted(path.name for path in exported.iterdir()) == NAMES


def test_the_baked_file_looks_like_the_relit_picture(tiny, exported):
    camera, gaussians = tiny.view("b_exact").camera, relightable_of(tiny.model)
    picture = seen(opened(exported / "baked.ply"), camera)
    expected = frame(gaussians, camera, gaussians.lights["a_0"], standard)
    is_covered = picture[..., 3] > 0.9999
    assert is_covered.float().mean() > 0.3
    torch.testing.assert_close(
        picture[..., :3][is_covered], expected[is_covered], rtol=0, atol=1e-3
    )


def test_without_a_view_colours_are_the_training_views_mean(tiny, tmp_path):
    parts = []
    for name, view in (("one", "a_0"), ("two", "a_1"), ("mean", None)):
        exported_to(tiny.model_path, tiny.folder, tmp_path / name, A_0, view=view)
        parts.append(opened(tmp_path / name / "baked.ply")["features"])
    assert (parts[0] - parts[1]).abs().max() > 1e-3  # reflections move
    torch.testing.assert_close(parts[2], 0.5 * (parts[0] + parts[1]), rtol=0, atol=1e-6)


def test_a_white_sky_is_white(tiny, tmp_path):
    light = LightOptions(PhotoSource(("a_0",)), sky="white")
    exported_to(tiny.model_path, tiny.folder, tmp_path, light)
    rows = plyfile.PlyData.read(str(tmp_path / "relightable.ply"))["vertex"].data
    is_sky = rows["is_sky"] > 0
    assert is_sky.sum() == 400
    for channel in range(3):
        white = 0.28209479 * rows[f"f_dc_{channel}"][is_sky] + 0.5
        np.testing.assert_allclose(white, 1.0, rtol=0, atol=1e-6)


def test_the_relightable_file_relights_like_the_model(tiny, exported, tmp_path):
    light = LightOptions(PhotoSource(("a_0", "a_1"), Sweep((0.3,))), yaw_deg=Sweep((40.0,)))
    pictures = []
    for model in (tiny.model_path, exported / "relightable.ply"):
        relight(model, tiny.folder, (tmp_path / "p.png",), CameraOptions(("a_1",)), light)
        pictures.append(read_rgb(tmp_path / "p.png"))
    assert (pictures[0] == pictures[1]).all()


def test_source_coordinates_undo_the_imports_similarity(tiny, tmp_path):
    rotation = torch.tensor([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    similarity = Similarity(4.0, rotation.double(), torch.tensor([1.0, 2.0, 3.0]).double())
    scene = load_scene(tiny.folder)
    gauge = Gauge.of(similarity)
    save_scene(scene.model_copy(update={"scene_from_source": gauge}), tmp_path / "scene")
    for coordinates in ("scene", "source"):
        exported_to(
            tiny.model_path, tmp_path / "scene", tmp_path / coordinates, A_0,
            coordinates=coordinates,
        )  # fmt: skip
    here, there = (opened(tmp_path / name / "baked.ply") for name in ("scene", "source"))
    # x_scene = 4 R x_source + t, with R a quarter turn about z
    mapped = 4 * there["means"] @ rotation.T + torch.tensor([1.0, 2.0, 3.0])
    torch.testing.assert_close(mapped, here["means"], rtol=1e-5, atol=1e-4)
    # The same picture from the camera in the source's own frame: R, t / 4 for the same frame.
    camera = tiny.view("a_0").camera
    cam_from_scene = camera.cam_from_world
    cam_from_source = torch.eye(4, dtype=torch.float64)
    cam_from_source[:3, :3] = cam_from_scene[:3, :3] @ rotation.double()
    offset = cam_from_scene[:3, :3] @ similarity.translation + cam_from_scene[:3, 3]
    cam_from_source[:3, 3] = offset / 4
    moved_camera = type(camera)(cam_from_source, camera.intrinsics, camera.width, camera.height)
    torch.testing.assert_close(seen(there, moved_camera), seen(here, camera), rtol=0, atol=2e-3)
    out = tmp_path / "p.png"
    pictures = []
    for model in (tiny.model_path, tmp_path / "source" / "relightable.ply"):
        relight(model, tiny.folder, (out,), CameraOptions(("a_1",)), A_0)
        pictures.append(read_rgb(out).astype(int))
    assert np.abs(pictures[0] - pictures[1]).max() <= 1


def test_glb_by_hand(exported):
    content = (exported / "baked.glb").read_bytes()
    magic, version, length = struct.unpack("<4sII", content[:12])
    assert (magic, version, length) == (b"glTF", 2, len(content))
    json_length, kind = struct.unpack("<I4s", content[12:20])
    assert kind == b"JSON"
    assert json_length % 4 == 0
    document = json.loads(content[20 : 20 + json_length])
    binary_length, kind = struct.unpack("<I4s", content[20 + json_length : 28 + json_length])
    binary = content[28 + json_length :]
    assert (kind, binary_length) == (b"BIN\0", len(binary))
    assert document["extensionsUsed"] == ["KHR_gaussian_splatting"]
    primitive = document["meshes"][0]["primitives"][0]
    assert primitive["mode"] == 0
    widths = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
    values = {}
    for name, index in primitive["attributes"].items():
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        width = widths[accessor["type"]]
        flat = np.frombuffer(binary, "<f4", accessor["count"] * width, view["byteOffset"])
        values[name.removeprefix("KHR_gaussian_splatting:")] = flat.reshape(-1, width)
    parts = opened(exported / "baked.ply")
    # Half a turn about x: up from -y to +y, and the front from -z to +z.
    np.testing.assert_array_equal(values["POSITION"], parts["means"].numpy() * [1, -1, -1])
    np.testing.assert_allclose(values["SCALE"], parts["scales"].numpy(), rtol=1e-6, atol=0)
    np.testing.assert_allclose(values["OPACITY"][:, 0], parts["opacities"], rtol=1e-6, atol=0)
    colours = 0.28209479 * values["SH_DEGREE_0_COEF_0"] + 0.5
    np.testing.assert_allclose(colours, parts["features"].numpy(), rtol=0, atol=1e-6)
    np.testing.assert_allclose(values["COLOR_0"][:, :3], colours, rtol=0, atol=1e-6)
    # Quaternions xyzw: (0, 1, 0, 0) wxyz times wxyz (a, b, c, d) is (-b, a, -d, c).
    a, b, c, d = torch.nn.functional.normalize(parts["quaternions"], dim=1).numpy().T
    product = np.stack([a, -d, c, -b], axis=-1)
    signs = np.sign((product * values["ROTATION"]).sum(axis=1, keepdims=True))
    np.testing.assert_allclose(values["ROTATION"], signs * product, rtol=0, atol=1e-6)
    accessor = document["accessors"][primitive["attributes"]["POSITION"]]
    np.testing.assert_allclose(accessor["max"], values["POSITION"].max(axis=0), rtol=1e-6, atol=0)


def test_what_an_export_refuses(tiny, tmp_path):
    moving = LightOptions(PhotoSource(("a_0",)), yaw_deg=Sweep((0.0, 90.0)))
    with pytest.raises(InputError, match="one light"):
        exported_to(tiny.model_path, tiny.folder, tmp_path, moving)
    with pytest.raises(InputError, match="no view 'a_9'"):
        exported_to(tiny.model_path, tiny.folder, tmp_path, A_0, view="a_9")
    lightless = tmp_path / "lightless"
    exported_to(tiny.model_path, tiny.folder, lightless, A_0)
    (lightless / "lights.json").unlink()
    with pytest.raises(InputError, match=r"put the export's lights\.json beside"):
        exported_to(lightless / "relightable.ply", tiny.folder, tmp_path, A_0)
    write_json(lightless / "lights.json", [])
    with pytest.raises(InputError, match=r"lights\.json"):
        exported_to(lightless / "relightable.ply", tiny.folder, tmp_path, A_0)
