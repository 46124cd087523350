"""r3gw.relight: against the training's renderer and photos; films; what is refused."""

from copy import deepcopy

import cv2
import numpy as np
import pytest
import torch
from support.tiny import opacities

from r3gw.files import InputError
from r3gw.geometry.cameras import pixel_rays
from r3gw.imaging.files import read_linear, read_rgb, write_exr
from r3gw.lighting import sh
from r3gw.model.lights import photo_light
from r3gw.model.rows import OCCLUSION
from r3gw.relight.cameras import CameraOptions, view_named
from r3gw.relight.film import FilmOptions, relight
from r3gw.relight.gaussians import relightable_of
from r3gw.relight.lights import LightOptions, MapSource, PhotoSource, SunSource
from r3gw.relight.load import require_scene_of
from r3gw.relight.outputs import output_for
from r3gw.relight.picture import frame
from r3gw.relight.sweep import Sweep
from r3gw.relight.tone import standard
from r3gw.relight.uncovered import other_sky_seen
from r3gw.relight.witnesses import Witnesses
from r3gw.rendering.compose import render
from r3gw.scene import load_scene


def picture(tiny, folder, light: LightOptions, view: str = "a_1", name: str = "out.png", **film):
    """One relit picture, as stored."""
    out = folder / name
    options = FilmOptions(**film)
    relight(tiny.model_path, tiny.folder, (out,), CameraOptions((view,)), light, options)
    return read_linear(out) if out.suffix == ".exr" else read_rgb(out).astype(int)


@torch.no_grad()
@pytest.mark.parametrize("with_shadows", [False, True])
def test_frame_is_the_trainings_rendering_and_sky_behind(tiny, with_shadows):
    """By the rule written out once more, where no photo's camera is known."""
    model = deepcopy(tiny.model)
    if with_shadows:
        transfer = 0.2 * torch.randn(len(model.foreground), 25)
        model.foreground.add_computed(OCCLUSION, transfer)
    light = photo_light(model, "a_0")
    camera = tiny.view("b_exact").camera
    trained = render(model, camera, light.sh, light.sky_coefficients)
    shown = frame(relightable_of(model), camera, light, standard)
    looks = torch.nn.functional.normalize(pixel_rays(camera), dim=-1)  # the camera is not turned
    behind = (sh.radiance(light.sky_coefficients, looks) + 0.5).clamp(0.0, 1.0)
    foreground, sky = opacities(model, camera)
    rest = 1 - foreground - sky
    expected = trained.colour + rest * (sky + 0.03) / (foreground + sky + 0.03) * behind
    torch.testing.assert_close(shown, expected, rtol=0, atol=1e-5)


@torch.no_grad()
def test_a_photos_own_picture_is_that_of_training(tiny):
    """What a training photo saw as black stays black from its place."""
    model = deepcopy(tiny.model)
    model.sky.rows["opacity_logits"].sub_(4.0)  # a sky with holes
    gaussians = relightable_of(model)
    witnesses = Witnesses(gaussians, [tiny.view(name).camera for name in ("a_0", "a_1")])
    for name in ("a_0", "a_1"):
        light, camera = photo_light(model, name), tiny.view(name).camera
        trained = render(model, camera, light.sh, light.sky_coefficients)
        assert (1 - trained.alpha).max() > 0.5  # there are holes
        shown = frame(gaussians, camera, light, standard, witnesses)
        alone = frame(gaussians, camera, light, standard)
        torch.testing.assert_close(shown, trained.colour, rtol=0, atol=0.02)
        assert (alone - trained.colour).max() > 0.2


def test_relit_under_the_true_map_equals_the_photo(tiny, tmp_path):
    scaled = tiny.env_map * 0.8 * torch.tensor([1.1, 1.0, 0.9])
    write_exr(tmp_path / "map.exr", scaled.numpy())
    light = LightOptions(MapSource(tmp_path / "map.exr"), sky="white")
    photo = read_rgb(tiny.folder / "images" / "b_exact.png")
    # The photo has white in place of the sky's Gaussians, and black behind all.
    camera = tiny.view("b_exact").camera
    foreground, sky = opacities(tiny.model, camera)
    photos = [tiny.view(name).camera for name in ("a_0", "a_1")]
    dark = Witnesses(relightable_of(tiny.model), photos).darkness(camera)
    expected = photo + 255 * (other_sky_seen(foreground, sky, dark) - sky).numpy()
    assert np.abs(picture(tiny, tmp_path, light, "b_exact") - expected).max() <= 1.1


def test_a_photos_light_brings_its_sky(tiny, tmp_path):
    photo = read_rgb(tiny.folder / "images" / "a_1.png").astype(int)
    own = picture(tiny, tmp_path, LightOptions(PhotoSource(("a_1",))))
    assert np.abs(own - photo).max() <= 6
    assert np.abs(own - photo).mean() < 0.2
    white = picture(tiny, tmp_path, LightOptions(PhotoSource(("a_1",)), sky="white"))
    assert white[:8].min() > 250
    other = picture(tiny, tmp_path, LightOptions(PhotoSource(("a_1",)), sky="learned:a_0"))
    assert np.abs(other[20:] - photo[20:]).mean() < 1
    assert np.abs(other[:8] - white[:8]).mean() > 5


def test_exr_is_the_png_before_its_gamma(tiny, tmp_path):
    dim = LightOptions(PhotoSource(("a_0",)), exposure=0.4)
    shown = picture(tiny, tmp_path, dim, name="dim.png")
    linear = picture(tiny, tmp_path, dim, name="dim.exr")
    assert linear.max() < 1.0
    np.testing.assert_allclose(linear ** (1 / 2.2) * 255, shown, rtol=0, atol=0.51)
    bright = picture(
        tiny, tmp_path, LightOptions(PhotoSource(("a_0",)), exposure=40.0), name="b.exr"
    )
    # 100 times the light is 100 times the linear value: no shoulder, no clamp.
    np.testing.assert_allclose(bright, 100 * linear, rtol=5e-3, atol=1e-2)
    assert bright.max() > 2.0


def test_the_map_is_seen_where_it_hangs(tiny, tmp_path):
    env_map = np.full((32, 64, 3), 0.2, np.float32)
    env_map[:, 32:, 0] = 0.8  # the right half, towards +x, is reddish
    write_exr(tmp_path / "map.exr", env_map)
    light = LightOptions(MapSource(tmp_path / "map.exr"), sky="map")
    seen = picture(tiny, tmp_path, light, name="seen.exr")
    # The camera looks along +z with x to the right: the edge stands in the picture's middle.
    np.testing.assert_allclose(seen[2, 2], (0.2, 0.2, 0.2), rtol=0, atol=1e-3)
    np.testing.assert_allclose(seen[2, -3], (0.8, 0.2, 0.2), rtol=0, atol=1e-3)


def test_film_goes_from_one_light_to_the_other(tiny, tmp_path):
    films = (tmp_path / "film.mp4", tmp_path / "frames" / "%03d.png")
    light = LightOptions(PhotoSource(("a_0", "a_1"), Sweep((0.0, 1.0))))
    choice = CameraOptions(("a_1",), width_px=47)  # odd: the film leaves out a column
    relight(tiny.model_path, tiny.folder, films, choice, light, FilmOptions(frames=5, fps=10.0))
    names = sorted(path.name for path in (tmp_path / "frames").iterdir())
    assert names == ["000.png", "001.png", "002.png", "003.png", "004.png"]
    for name, photo in (("000.png", "a_0"), ("004.png", "a_1")):
        relight(
            tiny.model_path, tiny.folder, (tmp_path / "one.png",), choice,
            LightOptions(PhotoSource((photo,))),
        )  # fmt: skip
        assert (read_rgb(tmp_path / "frames" / name) == read_rgb(tmp_path / "one.png")).all()
    film = cv2.VideoCapture(str(tmp_path / "film.mp4"))
    assert film.get(cv2.CAP_PROP_FPS) == 10
    decoded = []
    while True:
        is_there, bgr = film.read()
        if not is_there:
            break
        decoded.append(bgr[..., ::-1].astype(int))
    assert len(decoded) == 5
    for number, seen in enumerate(decoded):
        frame_ = read_rgb(tmp_path / "frames" / f"{number:03d}.png").astype(int)[:30, :46]
        assert seen.shape == frame_.shape
        assert np.abs(seen - frame_).mean() < 8
    assert {p.name for p in tmp_path.iterdir()} == {"film.mp4", "frames", "one.png"}


def test_a_scene_of_other_photos_is_refused(tiny):
    gaussians = relightable_of(tiny.model, "place/model.safetensors")
    scene = load_scene(tiny.folder)
    require_scene_of(gaussians, scene)
    others = tuple(v.model_copy(update={"name": f"other_{v.name}"}) for v in scene.views)
    with pytest.raises(InputError, match=r"place/model.safetensors: was trained on other photos"):
        require_scene_of(gaussians, scene.model_copy(update={"views": others}))


def test_a_photos_file_name_is_told_from_its_name(tiny):
    scene = load_scene(tiny.folder)
    with pytest.raises(InputError, match="views have no suffix: give 'a_1'"):
        view_named(scene, "a_1.png")


def test_a_film_that_fails_leaves_nothing(tmp_path):
    def fail() -> None:
        with output_for(tmp_path / "film.mp4", 2, 10.0) as film:
            film.write(torch.zeros(32, 32, 3))
            raise RuntimeError("the second frame is missing")

    with pytest.raises(RuntimeError, match="second frame"):
        fail()
    assert list(tmp_path.iterdir()) == []


SUN = SunSource(Sweep((30.0,)), Sweep((0.0,)))
A_0 = LightOptions(PhotoSource(("a_0",)))


@pytest.mark.parametrize(
    ("cameras", "light", "said"),
    [
        ("a_9", A_0, "no view 'a_9'; it has: a_0, a_1"),
        ("a_0", LightOptions(PhotoSource(("a_9",))), "no light of a photo 'a_9'; it has: a_0, a_1"),
        ("a_0", LightOptions(PhotoSource(("a_0", "a_1", "a_0"))), "or a blend of two, not 3"),
        (
            "a_0",
            LightOptions(PhotoSource(("a_0",), Sweep((0.5,)))),
            "needs the learned lights",
        ),
        ("a_0", LightOptions(PhotoSource(("a_0", "a_1"), Sweep((2.0,)))), "must be 0 to 1, not 2"),
        ("a_0", LightOptions(PhotoSource(("a_0",)), sky="blue"), "sky 'blue' is unknown"),
        (
            "a_0",
            LightOptions(PhotoSource(("a_0",)), sky="map"),
            "needs the light of an",
        ),
        ("a_0", LightOptions(SUN, sky="learned"), "say whose sky"),
        ("a_0", LightOptions(SunSource(Sweep((-5.0,)), Sweep((0.0,)))), "0 to 90, not -5"),
        (
            "a_0",
            LightOptions(PhotoSource(("a_0", "a_1"), Sweep((0.0, 1.0)))),
            "ask for more",
        ),
    ],
)
def test_contradictions_are_told(tiny, tmp_path, cameras, light, said):
    with pytest.raises(InputError, match=said):
        relight(
            tiny.model_path, tiny.folder, (tmp_path / "o.png",), CameraOptions((cameras,)), light
        )
    assert not (tmp_path / "o.png").exists()


@pytest.mark.parametrize(
    ("name", "frames", "said"), [("a.gif", 1, "'.gif'"), ("a.png", 3, "a_%04d.png")]
)
def test_outputs_by_name(tmp_path, name, frames, said):
    with pytest.raises(InputError, match=said):
        output_for(tmp_path / name, frames, 25.0)
