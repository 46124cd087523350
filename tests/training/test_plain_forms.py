"""Training without a single kernel ends where training with all of them does.

Every fused operator is replaced by its plain form in torch: splats, appearance, losses, density
statistics, Adam and the rasterizer. The two runs differ by the rounding of float32 alone. Adam
would make whole steps of it where a gradient is zero but for rounding, so its epsilon is raised
above that.
"""

import pandas as pd
import pytest
import torch
from support.flat_world import NAMES, flat_photos, flat_points
from support.settings import train_settings

from r3gw.native import kernels, ops
from r3gw.rendering.compose import render
from r3gw.training import optimizer
from r3gw.training.loop import train
from r3gw.training.start import initial_model

ITERATIONS = 40
REPLACED = (
    *("splats", "appearance", "picture_losses", "positivity", "flatness", "sky_depth"),
    *("add_gradient_norms", "adam_step", "is_usable", "rasterize", "known_gradient"),
)


def trained(losses="fused", **changes):
    """The model and its history after forty iterations that use every loss and densify twice."""
    settings = train_settings(
        iterations=ITERATIONS,
        paper_iterations=4000,
        geometry_losses_from=1000,
        seed=5,
        losses=losses,
        density={"first": 1500, "last": 3500, "interval": 1500, "reset_interval": None},
        **changes,
    )
    start = initial_model(flat_points(), NAMES, settings)
    # Balls would turn by the rounding of a gradient that is zero.
    generator = torch.Generator().manual_seed(1)
    light = start.appearance.light_head[-1].bias  # negative in places
    for learned in (start.foreground["log_scales"], start.sky.rows["log_scales"], light):
        learned.data += 0.4 * torch.randn(learned.shape, generator=generator)
    state = train(start, flat_photos(), settings)
    return state.model, pd.DataFrame(state.history.rows).fillna(0.0)


@torch.no_grad()
def pictures(model):
    """Colours from both cameras."""
    drawn = [
        render(model, photo.camera, *model.appearance(i)[:2]).colour
        for i, photo in enumerate(flat_photos())
    ]
    return torch.stack(drawn)


@pytest.fixture(autouse=True)
def gentle_adam(monkeypatch):
    """See the module's docstring; gradients that mean something are above 1e-5 here."""
    monkeypatch.setattr(optimizer, "EPSILON", 1e-7)


def assert_agree(found, expected):
    """Losses within 0.1 %, pictures within a twentieth of a grey level on average, counts equal."""
    ours, theirs = found[1], expected[1]
    assert len(ours) == ITERATIONS
    losses = [name for name in ours if name.startswith("loss_")]
    assert len(losses) >= 6
    for name in losses:
        assert float(theirs[name].iloc[-1]) > 1e-6, f"{name} never acts"
        pd.testing.assert_series_equal(ours[name], theirs[name], rtol=1e-3, atol=1e-6)
    pd.testing.assert_series_equal(ours.psnr, theirs.psnr, rtol=0, atol=0.005)
    assert theirs.num_foreground.iloc[-1] > 160  # both sets were densified
    for name in ("num_foreground", "num_sky"):
        assert ours[name].iloc[-1] == theirs[name].iloc[-1]
    difference = (pictures(found[0]) - pictures(expected[0])).abs()
    assert float(difference.mean()) < 2e-4
    assert float(difference.max()) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("silhouette", [False, True])
def test_every_kernel_replaced(monkeypatch, silhouette):
    changes = {"silhouette": {"enabled": silhouette}}
    expected = trained(**changes)
    for name in REPLACED:
        monkeypatch.setattr(ops, name, None)
    with kernels.switched_off():
        found = trained(**changes)
    monkeypatch.undo()
    assert_agree(found, expected)


def test_plain_losses_are_a_setting(monkeypatch):
    expected = trained()
    for name in ("picture_losses", "positivity", "flatness", "sky_depth", "known_gradient"):
        monkeypatch.setattr(ops, name, None)
    assert_agree(trained(losses="plain"), expected)
