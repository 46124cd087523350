"""r3gw.evaluation.decomposition on cases worked out by hand and on a scene with known parts."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from r3gw.evaluation.decomposition import (
    abs_rel,
    angles_deg,
    count_in_front,
    light_records,
    scale_per_channel,
    sky_band,
    sky_records,
    surface_records,
)
from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.geometry.cameras import Camera
from r3gw.imaging.files import write_exr
from r3gw.lighting import envmap
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.rendering.surfaces import foreground_and_sky, surfaces_of


def test_scale_is_found_per_channel():
    values = np.array([[1.0, 2.0, 0.0], [3.0, 1.0, 0.0]])
    scale = scale_per_channel(values, values * np.array([2.0, 0.5, 7.0]))
    np.testing.assert_allclose(scale, [2.0, 0.5, 0.0], rtol=1e-12, atol=0)


def test_angles_by_hand():
    normals = np.array([[0, 0, 1.0], [1.0, 0, 0], [0, 0, 0]])
    truth = np.array([[0, 0, 1.0], [0.5, 3**0.5 / 2, 0], [0, 1.0, 0]])
    np.testing.assert_allclose(angles_deg(normals, truth), [0, 60, 90], rtol=0, atol=1e-9)


def test_abs_rel_by_hand():
    depth, truth = np.array([2.0, 3.0]), np.array([4.0, 2.0])
    assert abs_rel(depth, truth) == pytest.approx(0.5, rel=1e-12, abs=0)


def test_sky_band_is_five_pixels_on_both_sides():
    is_sky = np.zeros((30, 8), np.bool_)
    is_sky[:12] = True
    rows = np.flatnonzero(sky_band(is_sky).all(axis=1))
    np.testing.assert_array_equal(rows, np.arange(12 - 5, 12 + 5))


@pytest.mark.parametrize("value", [True, False])
def test_no_outline_no_band(value):
    assert not sky_band(np.full((9, 9), value)).any()


def test_shares_add_up_to_the_picture(tiny):
    evaluated, view = tiny.evaluated, tiny.view("a_0")
    light, sky_light = tiny.model.appearance(0)[:2]
    whole = evaluated.render(view, Light(light.detach(), LearnedSky(sky_light.detach())))
    foreground, sky = foreground_and_sky(
        tiny.model, view.camera, light.detach(), sky_light.detach()
    )
    np.testing.assert_allclose(np.clip(foreground + sky, 0, 1), whole, rtol=0, atol=1e-5)
    assert foreground[:8].max() < 0.05
    assert sky[20:].mean() < 0.05


def evaluated_with(tiny, name: str, **truths: np.ndarray) -> EvaluatedScene:
    """The tiny scene with other true albedo, normals or depth in its exact view; sky stays 0."""
    view, paths = tiny.view("b_exact"), {}
    for kind, values in truths.items():
        picture = np.broadcast_to(values, (32, 48, 3)).astype(np.float32).copy()
        picture[:14] = 0
        paths[kind] = f"ground_truth/{kind}/{name}.exr"
        write_exr(tiny.folder / paths[kind], picture)
    view = view.model_copy(update={"truth": view.truth.model_copy(update=paths)})
    return replace(tiny.evaluated, scene=tiny.evaluated.scene.model_copy(update={"views": (view,)}))


def tilted(normals: np.ndarray, degrees: float) -> np.ndarray:
    """Normals turned about an axis across them; zeros stay."""
    across = np.cross(normals, [0.0, 1.0, 0.0])
    across /= np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-9)
    return normals * np.cos(np.radians(degrees)) + across * np.sin(np.radians(degrees))


def test_albedo_up_to_scale_normals_tilted_depth_stretched(tiny):
    ours = surfaces_of(tiny.model, tiny.view("b_exact").camera)
    evaluated = evaluated_with(
        tiny,
        "changed",
        albedo=ours.albedo * np.array([0.5, 1.0, 2.0]),
        normal=tilted(ours.normal, 10.0),
        depth=ours.depth[..., None] * 1.25,
    )
    (record,) = surface_records(evaluated)
    assert record["view"] == "b_exact"
    assert record["albedo_psnr"] == pytest.approx(60.0, rel=0, abs=1e-3)
    assert record["normal_mean_deg"] == pytest.approx(10.0, rel=0, abs=1e-3)
    assert record["normal_median_deg"] == pytest.approx(10.0, rel=0, abs=1e-3)
    assert record["depth_abs_rel"] == pytest.approx(0.2, rel=0, abs=1e-5)


def test_albedo_off_in_one_channel_is_told_per_channel(tiny):
    off = surfaces_of(tiny.model, tiny.view("b_exact").camera).albedo.copy()
    off[..., 2] += 0.2 * (np.arange(48) % 2)
    (record,) = surface_records(evaluated_with(tiny, "off", albedo=off))
    assert record["albedo_psnr_r"] > 59
    assert record["albedo_psnr_b"] < 25
    mean = np.mean([record[f"albedo_psnr_{c}"] for c in "rgb"])
    assert record["albedo_psnr"] == pytest.approx(mean, rel=1e-12, abs=0)


def test_light_error_forgives_one_scale_for_the_scene(tiny):
    view, evaluated = tiny.view("a_0"), tiny.evaluated
    light, *_ = tiny.model.appearance(0)
    path = tiny.folder / "envmaps" / "learned.exr"
    write_exr(path, envmap.draw(light.detach(), 64).numpy() * np.float32([3.0, 1.0, 0.5]))
    truth = tiny.view("b_exact").truth.model_copy(update={"env_map": "envmaps/learned.exr"})
    views = (view.model_copy(update={"truth": truth}),)
    scene = evaluated.scene.model_copy(update={"views": views})
    (record,) = light_records(replace(evaluated, scene=scene))
    assert record["light_error"] < 5e-3
    assert record["light_error_diffuse"] < 5e-3


def test_sky_figures(tiny):
    records = sky_records(tiny.evaluated)
    assert [record["view"] for record in records] == ["a_0", "a_1"]
    for record in records:
        assert record["sky_boundary_psnr"] > 50
        # The mask's sky reaches down to row 13, the wall up to about row 11 of 14.
        assert 0.0 < record["sky_foreground_alpha"] < 0.4


def test_points_before_a_surface_are_counted():
    """One before the wall, one behind it, one where there is no wall, one behind the camera."""
    pose = torch.eye(4, dtype=torch.float64)
    camera = Camera(pose, (10.0, 10.0, 8.0, 6.0), 16, 12)
    depth = np.zeros((12, 16))
    depth[6:] = 5.0
    means = torch.tensor(
        [[0.5, 0.5, 4.0], [0.5, 0.5, 6.0], [0.5, -0.5, 4.0], [0.5, 0.5, -4.0], [90.0, 0.5, 4.0]]
    )
    assert count_in_front(means, camera, depth) == 1
