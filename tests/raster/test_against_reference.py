"""The C++ rasterizer against the float64 plain-torch reference, forward and backward."""

from dataclasses import replace

import pytest
import torch
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from r3gw.raster import rasterize, reference

CHANNELS_AT_ONCE = 16


def pulls_of_passes(scene):
    """The kernels add up pulls of every sixteen channels; alpha pulls with the first of them."""
    total = 0
    for first in range(0, scene.features.shape[1], CHANNELS_AT_ONCE):
        part = slice(first, first + CHANNELS_AT_ONCE)
        alone = replace(
            scene,
            features=scene.features[:, part],
            background=scene.background[part],
            features_weight=scene.features_weight[..., part],
            alpha_weight=scene.alpha_weight * (first == 0),
        )
        total = total + alone.run(reference.rasterize, torch.float64)[1]["pulls2d"]
    return total


def assert_agree(scene, rtol, atol):
    """Images, footprints and every gradient agree; atol is relative to each tensor's size."""
    ours, our_gradients = scene.run(rasterize)
    theirs, their_gradients = scene.run(reference.rasterize, torch.float64)
    is_drawn = scene.features_weight != 0, scene.alpha_weight != 0
    pairs = {
        "features": (ours.features * is_drawn[0], theirs.features * is_drawn[0]),
        "alpha": (ours.alpha * is_drawn[1], theirs.alpha * is_drawn[1]),
        "radii_px": (ours.radii_px, theirs.radii_px),
        "means2d": (ours.means2d, theirs.means2d),
    }
    if scene.features.shape[1] > CHANNELS_AT_ONCE:
        their_gradients["pulls2d"] = pulls_of_passes(scene)
    for name, gradient in our_gradients.items():
        pairs[f"gradient of {name}"] = (gradient, their_gradients[name])
    for name, (actual, expected) in pairs.items():
        size = float(expected.detach().abs().max()) if expected.numel() else 0.0
        torch.testing.assert_close(
            actual.double(),
            expected,
            rtol=rtol,
            atol=atol * max(size, 1e-3),
            msg=lambda m, n=name: f"{n}: {m}",
        )


@pytest.mark.parametrize("channels", [1, 2, 3, 4, 5, 8, 9, 16, 20])
def test_forward_and_gradients(make_scene, monkeypatch, channels):
    scene = make_scene(seed=channels, channels=channels).without_cutoffs(monkeypatch)
    assert_agree(scene, rtol=1e-4, atol=2e-5)


@pytest.mark.parametrize(("width", "height"), [(1, 1), (3, 50), (16, 16), (17, 15), (64, 4)])
def test_any_image_size(make_scene, monkeypatch, width, height):
    scene = make_scene(seed=7, width=width, height=height).without_cutoffs(monkeypatch)
    assert_agree(scene, rtol=1e-4, atol=2e-5)


def test_opaque_scene_stops_early(make_scene, monkeypatch):
    scene = make_scene(seed=3, count=300, scale=0.3, opacity=2.0).without_cutoffs(monkeypatch)
    alpha = scene.run(rasterize)[0].alpha.detach()
    assert float(alpha.median()) > 0.9999
    assert_agree(scene, rtol=1e-3, atol=1e-4)


def test_thin_and_large_gaussians(make_scene, monkeypatch):
    scene = make_scene(seed=5, count=40, scale=0.5)
    scene.scales[:, 0] = 1e-4
    scene.scales[::2, 1] = 8.0
    assert_agree(scene.without_cutoffs(monkeypatch), rtol=1e-3, atol=3e-4)


@settings(
    max_examples=40,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    seed=st.integers(0, 2**31),
    count=st.integers(0, 80),
    channels=st.integers(1, 18),
    width=st.integers(1, 40),
    height=st.integers(1, 24),
    log10_scale=st.floats(-3, 0.5),
    opacity=st.floats(-4, 4),
)
def test_random_scenes(make_scene, monkeypatch, log10_scale, **shape):
    scene = make_scene(scale=10**log10_scale, **shape).without_cutoffs(monkeypatch)
    assert_agree(scene, rtol=2e-3, atol=5e-4)


@pytest.mark.parametrize(("channels", "wanted"), [(9, 7), (9, 3), (3, 0), (20, 18), (5, 5)])
def test_only_the_wanted_feature_gradients(make_scene, channels, wanted):
    scene = make_scene(seed=11, channels=channels)
    _, everything = scene.run(rasterize)
    _, some = scene.run(rasterize, num_feature_gradients=wanted)
    expected = everything["features"].clone()
    expected[:, wanted:] = 0
    torch.testing.assert_close(some["features"], expected, rtol=1e-6, atol=1e-6)
    for name in ("means", "quaternions", "scales", "opacities", "background", "means2d", "pulls2d"):
        torch.testing.assert_close(some[name], everything[name], rtol=1e-6, atol=1e-6)
