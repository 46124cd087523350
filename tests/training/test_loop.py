"""Training a tiny scene: it learns, it repeats byte for byte, it stops with a sentence."""

import json
import os

import pandas as pd
import pytest
import torch
from support.flat_world import flat_photos, flat_points
from support.settings import train_settings

from r3gw.imaging.files import read_rgb
from r3gw.model.initial import InitialPoints
from r3gw.model.model_file import save_model
from r3gw.training.checkpoint import Checkpoints
from r3gw.training.history import LEADING, History
from r3gw.training.loop import train
from r3gw.training.photos import Photo, camera_extent
from r3gw.training.settings import TrainSettings
from r3gw.training.start import initial_model
from r3gw.training.state import first_state
from r3gw.training.watched import ASKED, CURVES, PATIENCE_S, PICTURE, Watched, ask

PARTS = {"settings": "a", "code": "b"}


@pytest.fixture
def settings() -> TrainSettings:
    return train_settings(
        iterations=80,
        seed=5,
        rates={"short_run_boost": 5.0},
        density={"reset_interval": None, "max_gaussians": 600},
    )


@pytest.fixture
def photos() -> list[Photo]:
    return flat_photos()


@pytest.fixture
def initial() -> InitialPoints:
    return flat_points()


def run(settings, photos, initial):
    return train(initial_model(initial, ("a", "b"), settings), photos, settings)


def test_learns_the_photos(settings, photos, initial, tmp_path):
    run(settings, photos, initial).history.write(tmp_path / "history.csv")
    history = pd.read_csv(tmp_path / "history.csv")
    assert history.iteration.iloc[-1] == 80
    assert history.psnr.iloc[-5:].mean() > history.psnr.iloc[2:7].mean() + 5
    assert history.psnr.iloc[-5:].mean() > 18
    assert (history.loss_sky_depth.iloc[10:] > 0).all()


def test_same_seed_gives_the_same_bytes(settings, photos, initial, tmp_path):
    for name in ("first", "second"):
        save_model(run(settings, photos, initial).model, tmp_path / name / "model.safetensors")
    first = (tmp_path / "first/model.safetensors").read_bytes()
    assert first == (tmp_path / "second/model.safetensors").read_bytes()


def test_interrupted_run_continues_to_the_same_bytes(settings, photos, initial, tmp_path):
    """Break off after a checkpoint; the second attempt must not start afresh."""

    class Interrupted(Exception):
        pass

    class BreaksAt50(Checkpoints):
        def save_if_due(self, state):
            super().save_if_due(state)
            if state.iteration == 50:
                raise Interrupted

    settings = settings.model_copy(
        update={"model": settings.model.model_copy(update={"dropout": 0.2})}
    )
    save_model(run(settings, photos, initial).model, tmp_path / "whole/model.safetensors")
    first = initial_model(initial, ("a", "b"), settings)
    with pytest.raises(Interrupted):
        train(first, photos, settings, BreaksAt50(tmp_path, PARTS, interval_s=0.0))
    second = initial_model(initial, ("a", "b"), settings)
    checkpoints = Checkpoints(tmp_path, PARTS)
    assert checkpoints.restore(first_state(second, settings)).iteration == 50
    continued = train(second, photos, settings, checkpoints)
    save_model(continued.model, tmp_path / "continued/model.safetensors")
    assert (tmp_path / "whole/model.safetensors").read_bytes() == (
        tmp_path / "continued/model.safetensors"
    ).read_bytes()
    assert [row["iteration"] for row in continued.history.rows] == list(range(1, 81))
    checkpoints.discard()
    assert not list(tmp_path.glob(".checkpoint*"))


def test_a_watched_run_shows_itself_and_trains_the_same(
    settings, photos, initial, tmp_path, monkeypatch
):
    monkeypatch.setattr("r3gw.training.watched.INTERVAL_S", 1e9)  # one frame on any machine
    ask(tmp_path)
    watched = Watched(tmp_path)
    start = initial_model(initial, ("a", "b"), settings)
    state = train(start, photos, settings, watched=watched)
    progress = json.loads((tmp_path / CURVES).read_text())
    assert (progress["iteration"], progress["iterations"]) == (1, 80)
    assert progress["rows"] == state.history.rows[:1]
    photo = next(photo for photo in photos if photo.name == progress["photo"])
    shown = read_rgb(tmp_path / PICTURE)
    assert shown.shape == (24, 64, 3)
    assert (shown[:, :32] == photo.planes.permute(1, 2, 0).numpy()).all()
    for name, rows in run(settings, photos, initial).model.foreground.values.items():
        torch.testing.assert_close(state.model.foreground[name], rows, rtol=0, atol=0)
    watched.discard()
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_nobody_watches_any_more_writes_nothing(settings, photos, initial, tmp_path):
    def watch():
        start = initial_model(initial, ("a", "b"), settings)
        train(start, photos, settings, watched=Watched(tmp_path))
        return sorted(path.name for path in tmp_path.iterdir())

    assert watch() == []
    ask(tmp_path)
    long_ago = (tmp_path / ASKED).stat().st_mtime - 2 * PATIENCE_S
    os.utime(tmp_path / ASKED, (long_ago, long_ago))
    assert watch() == [ASKED]


def test_another_seed_gives_another_model(settings, photos, initial):
    one = run(settings, photos, initial).model.foreground["means"]
    other = settings.model_copy(update={"seed": 6})
    two = run(other, photos, initial).model.foreground["means"]
    assert one.shape != two.shape or not torch.equal(one, two)


def test_warm_up_moves_only_what_the_separation_loss_touches(settings, photos, initial):
    """During warm-up the appearance model gets no gradient."""
    short = settings.model_copy(update={"iterations": 10, "warm_up": 40000})
    model = initial_model(initial, ("a", "b"), short)
    before = {k: v.clone() for k, v in model.appearance.state_dict().items()}
    trained = train(model, photos, short).model
    for name, value in trained.appearance.state_dict().items():
        torch.testing.assert_close(value, before[name], rtol=0, atol=0)


def test_extent_is_the_largest_distance_from_the_mean(photos):
    assert camera_extent([p.camera for p in photos]) == pytest.approx(1.1 * 0.2, rel=1e-6)


def test_every_part_of_the_loss_gets_a_column(settings, photos, initial, tmp_path):
    """Also one that nobody told the history of, and one that acts late; before, it is 0."""
    state = run(settings, photos, initial)
    state.history.rows[-1]["loss_of_tomorrow"] = 2.0
    state.history.write(tmp_path / "history.csv")
    table = pd.read_csv(tmp_path / "history.csv")
    losses = [name for name in table.columns if name.startswith("loss_")]
    assert "loss_ground" not in losses
    told = [name for name in losses if name != "loss_of_tomorrow"]
    assert (table[told].sum(axis=1) - table.loss).abs().max() < 2e-4
    assert table.loss_reconstruction.iloc[0] == 0  # warm-up
    assert table.loss_reconstruction.iloc[-1] > 0
    assert table.loss_of_tomorrow.tolist() == [0.0] * (len(table) - 1) + [2.0]


def test_history_of_a_continued_run_has_the_same_bytes(tmp_path):
    """A checkpoint gives rows back with their keys in another order."""
    row = dict.fromkeys((*LEADING, "loss_separation", "loss_light"), 1.0)
    later = row | {"loss_normal": 2.0}
    for name, rows in (
        ("calm", [row, later]),
        ("continued", [dict(sorted(row.items())), later]),
        ("late", [dict(sorted(row.items())), dict(sorted(later.items()))]),
    ):
        history = History(2)
        history.resume(rows, 0.0)
        history.write(tmp_path / name)
    calm = (tmp_path / "calm").read_bytes()
    assert calm.startswith(b"iteration,loss,psnr,num_foreground,num_sky,sky_radius,loss_light,")
    assert (tmp_path / "continued").read_bytes() == calm
    assert (tmp_path / "late").read_bytes() == calm


def test_a_disk_that_takes_no_frame_does_not_end_the_run(
    settings, photos, initial, tmp_path, caplog
):
    ask(tmp_path)
    (tmp_path / PICTURE).mkdir()  # a folder where the picture should go: the rename is refused
    start = initial_model(initial, ("a", "b"), settings)
    state = train(start, photos, settings, watched=Watched(tmp_path))
    assert state.iteration == settings.iterations
    assert "nothing is shown to those who watch" in caplog.text
