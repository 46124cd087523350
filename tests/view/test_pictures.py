"""The page's pictures are those of `r3gw relight`: orientation, gamma, shading and compositing."""

import json
from base64 import b64decode, b64encode
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from support.blob import PHOTOS, SIZE, VIEWS
from support.chromium import Session

from r3gw.imaging.files import write_exr
from r3gw.imaging.pictures import bytes_from_display
from r3gw.lighting.light import Light
from r3gw.relight.lights import LightOptions, MapSource, PhotoSource, SunSource, light_over_time
from r3gw.relight.picture import frame
from r3gw.relight.seen import Coverage
from r3gw.relight.sweep import Sweep
from r3gw.relight.tone import CURVES
from r3gw.relight.witnesses import Witnesses
from r3gw.scene import load_scene
from r3gw.view.page import page_html
from r3gw.view.payload import payload_of

LEAST_PSNR = 40.0  # dB; 30 are asked for, 46 and more are reached
DROP = """
const input = document.querySelector("#map-file");
const files = new DataTransfer();
const bytes = Uint8Array.from(atob("{content}"), (c) => c.charCodeAt(0));
files.items.add(new File([bytes], "{name}"));
input.files = files.files;
input.dispatchEvent(new Event("change"));
const before = r3gwApp.mapsRead;
while (r3gwApp.mapsRead === before) await new Promise((resolve) => setTimeout(resolve, 10));
"""


def drop(path: Path) -> str:
    """Job that gives the page a map's file."""
    return DROP.format(name=path.name, content=b64encode(path.read_bytes()).decode())


def shot(view: str, **state: object) -> str:
    """Job that draws a view in a state and returns it as PNG."""
    arguments = json.dumps([{"auto": False, **state}, view, *SIZE])
    return f"return r3gwApp.probe(...{arguments});"


def pixels(url: str) -> np.ndarray:
    """The picture of a data URL, display values."""
    data = np.frombuffer(b64decode(url.split(",")[1]), np.uint8)
    return cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1] / 255.0


def psnr(a: np.ndarray, b: np.ndarray) -> float:
    """In dB, of display values."""
    return float(-10 * np.log10(((a - b) ** 2).mean() + 1e-12))


@pytest.fixture(scope="module")
def maps(tmp_path_factory) -> dict[str, Path]:
    """One lopsided map in every format: bright spots that no turn or mirror maps on each other."""
    folder = tmp_path_factory.mktemp("maps")
    light = np.full((64, 128, 3), 0.15, np.float32)
    light[10:16, 20:28] = (3.0, 1.5, 0.5)
    light[30:34, 100:110] = (0.1, 0.4, 0.9)
    light *= np.linspace(0.3, 2.5, 128, dtype=np.float32)[:, None]
    light[50:] = (0.05, 0.1, 0.02)
    paths = {kind: folder / f"map.{kind}" for kind in ("exr", "hdr", "png")}
    write_exr(paths["exr"], light)
    assert cv2.imwrite(str(paths["hdr"]), light[..., ::-1])
    eight_bits = bytes_from_display(torch.from_numpy(light).clamp(0, 1) ** (1 / 2.2))
    assert cv2.imwrite(str(paths["png"]), eight_bits[..., ::-1])
    return paths


@pytest.mark.slow
@pytest.mark.usefixtures("browser")
def test_five_views_under_every_light(gaussians, scene_folder, html, maps, tmp_path):
    """Learned lights with their skies, the sun through a filmic curve, and dropped maps."""
    photo, other = PHOTOS[1], PHOTOS[2]
    sun = SunSource(Sweep((35.0,)), Sweep((150.0,)), 3.5)
    turn = Sweep((70.0,))
    learned = PhotoSource((photo, other), Sweep((0.3,)))
    lights = {
        "learned": (LightOptions(learned), "standard"),
        "sun": (LightOptions(sun, exposure="auto"), "filmic"),
        "white": (LightOptions(sun, exposure=0.05, sky="white"), "reinhard"),
        "exr": (LightOptions(MapSource(maps["exr"]), turn), "standard"),
        "hdr": (LightOptions(MapSource(maps["hdr"]), turn), "standard"),
        "png": (LightOptions(MapSource(maps["png"]), turn, sky=f"learned:{photo}"), "standard"),
    }
    day = {"light": "sun", "elevation": 35, "azimuth": 150, "turbidity": 3.5}
    states = {
        "learned": {"light": "learned", "photo": photo, "photo2": other, "blend": 0.3},
        "sun": {**day, "auto": True, "tone": "filmic"},
        "white": {**day, "stops": float(np.log2(0.05)), "sky": "white", "tone": "reinhard"},
        "exr": {"light": "map", "yaw": 70},
        "hdr": {"light": "map", "yaw": 70},
        "png": {"light": "map", "yaw": 70, "sky": "learned", "photo": photo},
    }
    session = Session(html)
    for kind in lights:
        if kind in maps:
            session.jobs.append(drop(maps[kind]))
        session.jobs += [shot(view, **states[kind]) for view in VIEWS]
    found = iter(url for url in session.run(tmp_path) if url is not None)

    scene = load_scene(scene_folder)
    views = {view.name: view for view in scene.views}
    witnesses = Witnesses(gaussians, [view.camera for view in scene.split("train")])
    for kind, (options, tone) in lights.items():
        light = light_over_time(gaussians, options)(0.0)
        for name in VIEWS:
            camera = views[name].camera
            expected = frame(gaussians, camera, light, CURVES[tone], witnesses).clamp(0, 1)
            assert psnr(pixels(next(found)), expected.numpy()) > LEAST_PSNR, (kind, name)
    assert session.complaints == []


@pytest.mark.slow
@pytest.mark.usefixtures("browser")
def test_guessed_parts_are_the_same_and_dark(gaussians, scene_folder, html, tmp_path):
    """Surfaces that two photos see stay as they are."""
    session = Session(html, jobs=[shot(VIEWS[1], show="guessed", photo=PHOTOS[0])])
    shown = pixels(session.run(tmp_path)[0])
    scene = load_scene(scene_folder)
    camera, light = scene.views[1].camera, gaussians.lights[PHOTOS[0]]
    photos = [view.camera for view in scene.split("train")]
    is_well = Coverage(gaussians, photos).is_well_seen(camera.centre)
    assert 0.1 < is_well.float().mean() < 0.9
    asked = (gaussians, camera, light, CURVES["standard"], Witnesses(gaussians, photos))
    expected, plain = frame(*asked, is_well).clamp(0, 1), frame(*asked).clamp(0, 1)
    assert psnr(shown, expected.numpy()) > LEAST_PSNR
    assert psnr(shown, plain.numpy()) < 30


@pytest.mark.slow
@pytest.mark.usefixtures("browser")
def test_a_mirrored_map_would_be_noticed(gaussians, scene_folder, html, maps, tmp_path):
    """The margin of the test above: a map that hangs the wrong way round is far off."""
    session = Session(html, jobs=[drop(maps["exr"]), shot(VIEWS[0], light="map", yaw=70)])
    shown = pixels(session.run(tmp_path)[-1])
    scene = load_scene(scene_folder)
    camera = scene.views[0].camera
    witnesses = Witnesses(gaussians, [view.camera for view in scene.split("train")])
    exact = Light.from_map(maps["exr"])
    for wrong in (exact.turned(-70.0), exact.turned(250.0), exact):
        picture = frame(gaussians, camera, wrong, CURVES["standard"], witnesses).clamp(0, 1)
        assert psnr(shown, picture.numpy()) < 30


@pytest.mark.slow
@pytest.mark.usefixtures("browser")
def test_a_scene_of_degree_two_without_reflections(scene_folder, gaussians, tmp_path):
    """`specular: false` lowers the light to nine coefficients."""
    plain = replace(
        gaussians,
        with_specular=False,
        light_degree=2,
        occlusion=None,
        lights={name: Light(light.sh[:9], light.sky) for name, light in gaussians.lights.items()},
    )
    scene = load_scene(scene_folder)
    session = Session(page_html(payload_of(plain, scene, scene_folder)))
    session.jobs = [shot(VIEWS[3], light="learned", photo=PHOTOS[0])]
    shown = pixels(session.run(tmp_path)[0])
    light = plain.lights[PHOTOS[0]]
    camera = scene.views[3].camera
    witnesses = Witnesses(plain, [view.camera for view in scene.split("train")])
    expected = frame(plain, camera, light, CURVES["standard"], witnesses).clamp(0, 1)
    assert psnr(shown, expected.numpy()) > LEAST_PSNR
