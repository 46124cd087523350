"""r3gw.relight.trained: what `import r3gw` gives, against the command line's way and by hand."""

from pathlib import Path
from shutil import copytree

import numpy as np
import pytest
import torch

import r3gw
from r3gw.imaging.files import read_rgb, write_exr
from r3gw.lighting.skies import MapSky
from r3gw.relight.cameras import CameraOptions
from r3gw.relight.film import relight
from r3gw.relight.lights import LightOptions, MapSource, PhotoSource


@pytest.fixture
def scene(tiny) -> r3gw.TrainedScene:
    """The tiny scene, opened."""
    return r3gw.load(tiny.model_path, tiny.folder)


def as_bytes(picture: np.ndarray) -> np.ndarray:
    return np.rint(255 * picture).astype(int)


def test_a_rendered_array_is_the_picture_of_the_command_line(tiny, scene, tmp_path):
    write_exr(tmp_path / "map.exr", tiny.env_map.numpy())
    light = r3gw.Light.from_map(tmp_path / "map.exr").turned(30.0)
    for options, ours in (
        (LightOptions(PhotoSource(("a_1",))), scene.render("b_exact", "a_1")),
        (
            LightOptions(MapSource(tmp_path / "map.exr"), sky="white"),
            scene.render("b_exact", light.turned(-30.0), sky="white"),
        ),
    ):
        out = tmp_path / "out.png"
        relight(tiny.model_path, tiny.folder, (out,), CameraOptions(("b_exact",)), options)
        np.testing.assert_allclose(as_bytes(ours), read_rgb(out), rtol=0, atol=1)
    assert ours.dtype == np.float32
    assert ours.shape == (32, 48, 3)
    assert np.abs(scene.render("b_exact", light) - ours).mean() > 0.02


def test_it_introduces_itself_in_one_line(tiny, scene):
    counts = f"{scene.gaussians.num_foreground:,} foreground and {scene.gaussians.num_sky:,} sky"
    expected = f"<TrainedScene of {tiny.model_path}: {counts} Gaussians, 4 cameras, 2 lights>"
    assert repr(scene) == expected


def test_tones_and_skies(scene):
    light = scene.lights["a_0"]
    shown, linear = (scene.render("a_0", light.times(0.4), tone=t) for t in ("standard", "linear"))
    np.testing.assert_allclose(linear ** (1 / 2.2), shown, rtol=0, atol=1e-4)
    bright = scene.render("a_0", light.times(40.0), tone="linear")
    np.testing.assert_allclose(bright, 100 * linear, rtol=1e-3, atol=1e-2)
    white = scene.render("a_0", light, sky="white")
    assert white[:8].min() > 0.98
    other = scene.render("a_0", light, sky=scene.lights["a_1"].times(0.2))
    assert np.abs(other[:8] - scene.render("a_0", light)[:8]).mean() > 0.05
    # The wall is not quite opaque: up to 4 % of what is behind shows through.
    np.testing.assert_allclose(other[20:], white[20:], rtol=0, atol=0.04)


def test_exposed_lights_are_as_strong_as_learned_ones(scene):
    light = scene.exposed(r3gw.Light.from_pixels(torch.full((8, 16, 3), 7.0)))
    strengths = sorted(each.strength for each in scene.lights.values())
    assert light.strength == pytest.approx(strengths[0], rel=1e-5, abs=0)
    assert isinstance(light.sky, MapSky)
    up = torch.tensor([[0.0, -1.0, 0.0]])
    # A uniform radiance L has the constant coefficient L * sqrt(4 pi).
    expected = light.strength / np.sqrt(4 * np.pi)
    assert light.sky.radiance(up)[0, 0].item() == pytest.approx(expected, rel=1e-5, abs=0)


def test_a_run_of_the_workflow_finds_its_cameras(tiny, tmp_path):
    run = tmp_path / "tiny" / "full" / "seed0"
    copytree(tiny.model_path.parent, run)
    assert r3gw.load(run).cameras == {}
    copytree(tiny.folder, tmp_path / "tiny" / "scene", ignore=lambda *_: {"run"})
    found = r3gw.load(run)
    assert list(found.cameras) == ["a_0", "a_1", "b_exact", "c_swept"]
    assert list(found.lights) == ["a_0", "a_1"]


def test_what_is_missing_is_told(tiny, scene, tmp_path):
    with pytest.raises(r3gw.InputError, match="no view 'a_9'"):
        scene.render("a_9", "a_0")
    with pytest.raises(r3gw.InputError, match="no light of a photo 'b_exact'"):
        scene.render("a_0", "b_exact")
    alone = r3gw.load(tiny.model_path)
    with pytest.raises(r3gw.InputError, match=r"no cameras are known; load it with the folder"):
        alone.render("a_0", "a_0")
    with pytest.raises(r3gw.InputError, match="an export needs the photos' cameras"):
        r3gw.export(alone, tmp_path, alone.lights["a_0"])
    with pytest.raises(r3gw.InputError, match="only learned lights"):
        r3gw.Light(torch.zeros(25, 3)).blended(scene.lights["a_0"], 0.5)
    with pytest.raises(r3gw.InputError, match="turbidity must be 1 to 10, not 0"):
        r3gw.Light.sun(30.0, 90.0, turbidity=0.0)


def test_a_camera_looks_at_its_target():
    camera = r3gw.Camera.looking_at(
        (1.0, 2.0, 9.0), position=(0.0, 0.0, 1.0), fov_deg=90.0, width=80, height=60
    )
    torch.testing.assert_close(camera.centre, torch.tensor([0.0, 0.0, 1.0]).double())
    local = camera.cam_from_world @ torch.tensor([1.0, 2.0, 9.0, 1.0]).double()
    # sqrt(1 + 4 + 64) straight ahead, in the middle of the picture
    torch.testing.assert_close(local[:3], torch.tensor([0.0, 0.0, 69.0**0.5]).double())
    assert camera.intrinsics == pytest.approx((40.0, 40.0, 40.0, 30.0), rel=1e-12, abs=0)
    # The horizon is level: the camera's right has no vertical part, and its down points down (+y).
    assert camera.cam_from_world[0, 1].item() == pytest.approx(0.0, rel=0, abs=1e-12)
    assert camera.cam_from_world[1, 1] > 0.9
    with pytest.raises(ValueError, match="straight up or down"):
        r3gw.Camera.looking_at((0.0, 5.0, 0.0), position=(0.0, 0.0, 0.0))


def test_every_public_name_is_there_and_typed():
    stub = (Path(r3gw.__file__).with_name("__init__.pyi")).read_text()
    typed = {line.rpartition(" as ")[2] for line in stub.splitlines() if " as " in line}
    assert typed | {"__version__"} == set(r3gw.__all__)
    for name in r3gw.__all__:
        assert getattr(r3gw, name).__doc__
        assert name in dir(r3gw)
    with pytest.raises(AttributeError, match="no attribute 'lod'"):
        getattr(r3gw, "lod")  # noqa: B009
