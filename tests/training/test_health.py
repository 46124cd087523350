"""Faults injected into a training: it stops with a sentence and keeps its last good checkpoint."""

import logging

import pytest
import torch
from support.settings import train_settings

from r3gw.files.errors import InputError
from r3gw.geometry.cameras import Camera
from r3gw.model.initial import InitialPoints
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.training import loop
from r3gw.training.checkpoint import Checkpoints
from r3gw.training.loop import train
from r3gw.training.photos import Photo
from r3gw.training.start import initial_model
from r3gw.training.state import first_state

PARTS = {"settings": "a"}
FAULT_AT = 12


@pytest.fixture
def settings():
    """Without densification, which one view's extent would make meaningless."""
    return train_settings(
        iterations=40,
        warm_up=0,
        geometry_losses_from=0,
        density={"first": 0, "interval": 1_000_000, "reset_interval": None},
    )


@pytest.fixture
def photos() -> list[Photo]:
    """One view of grey under sky."""
    camera = Camera(torch.eye(4, dtype=torch.float64), (30.0, 30.0, 16.0, 12.0), 32, 24)
    is_sky = torch.zeros(24, 32, dtype=torch.bool)
    is_sky[:8] = True
    planes = torch.full((3, 24, 32), 128, dtype=torch.uint8)
    return [Photo("front", camera, planes, torch.ones_like(is_sky), is_sky)]


@pytest.fixture
def initial() -> InitialPoints:
    generator = torch.Generator().manual_seed(0)
    points = torch.rand(60, 3, generator=generator) * torch.tensor([6.0, 2.4, 0.2])
    points += torch.tensor([-3.0, -0.5, 4.0])
    dome = SkyDome(torch.tensor([0.0, 0.5, 0.0]), 8.0, (-1.0, 1.0))
    return InitialPoints(points, dome, sample_dome(dome, 40, generator))


def failed(model, photos, settings, tmp_path) -> str:
    """The sentence that ends a training; its checkpoint of before must be good."""
    checkpoints = Checkpoints(tmp_path, PARTS, interval_s=0.0)
    with pytest.raises(InputError) as caught:
        train(model, photos, settings, checkpoints)
    kept = Checkpoints(tmp_path, PARTS).restore(first_state(model, settings))
    assert kept.iteration == FAULT_AT - 1
    for value in kept.model.foreground.values.values():
        assert bool(value.isfinite().all())
    assert f"the state of iteration {FAULT_AT - 1} is kept in {checkpoints.path}" in str(
        caught.value
    )
    assert "\n" not in str(caught.value)
    return str(caught.value)


def break_at(monkeypatch, name, broken):
    """Let a function of the loop go wrong in iteration `FAULT_AT`."""
    calls = 0
    whole = getattr(loop, name)

    def wrapped(*args):
        nonlocal calls
        calls += 1
        return broken(whole, *args) if calls == FAULT_AT else whole(*args)

    monkeypatch.setattr(loop, name, wrapped)


def test_a_loss_that_is_not_finite_is_named(monkeypatch, photos, settings, initial, tmp_path):
    def broken(whole, *args):
        rendering, loss, parts = whole(*args)
        return rendering, loss * torch.nan, parts | {"normal": float("nan")}

    break_at(monkeypatch, "objective", broken)
    found = failed(initial_model(initial, ("front",), settings), photos, settings, tmp_path)
    assert (
        "diverged at iteration 12 on photo front with 100 Gaussians: the loss part(s) normal"
        in (found)
    )


@pytest.mark.parametrize(
    ("name", "row", "value"),
    [("means", 3, torch.nan), ("log_scales", 0, torch.inf), ("albedo_logits", 5, torch.nan)],
)
def test_a_parameter_that_is_not_finite_is_named(
    monkeypatch, photos, settings, initial, tmp_path, name, row, value
):
    """Set by the optimizer's step, as a gradient that is not finite would."""
    model = initial_model(initial, ("front",), settings)

    def broken(whole, *args):
        whole(*args)
        with torch.no_grad():
            model.foreground[name][row] = value

    break_at(monkeypatch, "adam_step", broken)
    found = failed(model, photos, settings, tmp_path)
    assert f"by iteration 12 with 100 Gaussians: 3 of 180 values of 'foreground.{name}'" in found


def test_without_checkpoints_the_next_photo_finds_it(monkeypatch, photos, settings, initial):
    model = initial_model(initial, ("front",), settings)

    def broken(whole, *args):
        whole(*args)
        with torch.no_grad():
            model.sky.radius.fill_(torch.nan)

    break_at(monkeypatch, "adam_step", broken)
    with pytest.raises(InputError, match=r"by iteration 1\d with .* 'sky\.radius' are not finite"):
        train(model, photos, settings)


def test_a_light_without_bounds_is_one_sentence(photos, settings, initial):
    """No parameter is to blame yet: the renderer refuses colours that are not finite."""
    model = initial_model(initial, ("front",), settings)
    with torch.no_grad():
        model.appearance.embedding[:] = 1e30
    with pytest.raises(InputError, match=r"diverged at iteration 1 on photo front"):
        train(model, photos, settings)


def test_no_foreground_left_ends_the_training(monkeypatch, photos, settings, initial, tmp_path):
    model = initial_model(initial, ("front",), settings)
    density = settings.density.model_copy(update={"interval": FAULT_AT * 1000})
    settings = settings.model_copy(update={"density": density})

    def broken(whole, *args):
        whole(*args)
        with torch.no_grad():
            model.foreground["opacity_logits"].fill_(-20.0)

    break_at(monkeypatch, "adam_step", broken)
    found = failed(model, photos, settings, tmp_path)
    assert "lost all foreground Gaussians at iteration 12; check the masks" in found


def test_an_empty_sky_and_a_full_foreground_are_noted(photos, settings, initial, caplog):
    density = settings.density.model_copy(
        update={
            "interval": 10_000,
            "threshold_first": 1e-12,
            "threshold_last": None,
            "max_gaussians": 70,
        }
    )
    settings = settings.model_copy(update={"density": density})
    model = initial_model(initial, ("front",), settings)
    with torch.no_grad():
        model.sky.rows["opacity_logits"].fill_(-20.0)
    with caplog.at_level(logging.WARNING, "r3gw"):
        notes = train(model, photos, settings).notes
    assert notes["sky_empty_at"] == 10
    assert notes["foreground_capped_at"] == 10
    assert "iteration 10: the sky has no Gaussians left" in caplog.text
    assert "iteration 10: density.max_gaussians (70) keeps the foreground small" in caplog.text
