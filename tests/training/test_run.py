"""The training stage, killed and continued with the same and with other inputs."""

import json
import shutil

import numpy as np
import pytest
import torch
from support.settings import train_settings
from support.tiny import TRAIN

from r3gw.files.arrays import read_arrays
from r3gw.files.errors import InputError
from r3gw.imaging.files import write_image
from r3gw.masks.found import load_found
from r3gw.model.initial import InitialPoints, save_initial
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.scene import load_scene
from r3gw.training import occluders, run
from r3gw.training.checkpoint import Checkpoints
from r3gw.training.run import RunFiles, run_training

ITERATIONS, KILLED_AT = 16, 10
ALWAYS = {"enabled": True, "first": 0, "interval": 4000, "contrast": 0.35, "most": 0.4}


def points(shift: float = 0.0) -> InitialPoints:
    generator = torch.Generator().manual_seed(0)
    xyz = torch.rand(120, 3, generator=generator) * torch.tensor([6.0, 3.0, 0.3])
    dome = SkyDome(torch.tensor([0.0, 0.0, 6.0]), 12.0, (-1.0, 1.0))
    start = xyz + torch.tensor([-3.0 + shift, 0.0, 6.0])
    return InitialPoints(start, dome, sample_dome(dome, 40, generator))


@pytest.fixture
def files(tiny, tmp_path) -> RunFiles:
    """A copy of the tiny scene, its initial points and settings of a few iterations."""
    shutil.copytree(tiny.folder, tmp_path / "scene", ignore=shutil.ignore_patterns("masks", "run"))
    shutil.copytree(tiny.masks, tmp_path / "masks")
    save_initial(points(), tmp_path / "initial.npz")
    settings = train_settings(
        iterations=ITERATIONS,
        warm_up=0,
        geometry_losses_from=0,
        density={"first": 0, "interval": 15_000, "reset_interval": None},  # every 6 iterations
        model={"embedding_size": 8, "hidden_size": 8, "light_hidden_size": 8},
    )
    (tmp_path / "settings.json").write_text(settings.model_dump_json())
    names = ("scene", "masks", "initial.npz", "settings.json", "run")
    return RunFiles(*(tmp_path / name for name in names))


def go(files: RunFiles, num_threads: int = 1, **options) -> bytes:
    """Train; return the model's bytes."""
    try:
        run_training(files, scene="tiny", variant="full", num_threads=num_threads, **options)
    finally:
        torch.set_num_threads(1)
    return (files.target / "model.safetensors").read_bytes()


class Killed(Exception):
    """Stands for the end of the process."""


@pytest.fixture
def checkpoint(files, monkeypatch):
    """The checkpoint of a run that was killed after iteration `KILLED_AT`."""
    return killed(files, monkeypatch)


def killed(files: RunFiles, monkeypatch):
    """Kill a run after iteration `KILLED_AT`; its checkpoint."""
    save = Checkpoints.save_if_due

    def save_and_die(self, state):
        save(self, state)
        if state.iteration == KILLED_AT:
            raise Killed

    with monkeypatch.context() as patched:
        patched.setattr(Checkpoints, "save_if_due", save_and_die)
        with pytest.raises(Killed):
            go(files, checkpoint_s=0.0)
    (found,) = files.target.glob(".checkpoint-*")
    return found


def undisturbed(files: RunFiles, tmp_path, **options) -> bytes:
    return go(
        RunFiles(files.scene, files.masks, files.initial, files.settings, tmp_path), **options
    )


def edit_mask(files: RunFiles) -> None:
    is_valid = np.ones((32, 48), np.bool_)
    is_valid[20:, :20] = False
    write_image(files.masks / "is_valid" / f"{TRAIN[0]}.png", is_valid)


def edit_points(files: RunFiles) -> None:
    save_initial(points(0.1), files.initial)


def edit_photo(files: RunFiles) -> None:
    write_image(files.scene / "images" / f"{TRAIN[1]}.png", np.full((32, 48, 3), 90, np.uint8))


def edit_camera(files: RunFiles) -> None:
    path = files.scene / "scene.json"
    path.write_text(path.read_text().replace("45.0", "46.0"))


EDITS = {
    "masks": edit_mask,
    "initial points": edit_points,
    "photos": edit_photo,
    "photos ": edit_camera,
}


def test_a_killed_run_goes_on_and_ends_with_the_same_bytes(files, checkpoint, tmp_path, caplog):
    caplog.set_level("INFO", "r3gw")
    (files.target / f".{checkpoint.stem}.123.safetensors").write_bytes(b"half")
    assert go(files) == undisturbed(files, tmp_path / "other")
    assert f"continuing from {checkpoint} at iteration {KILLED_AT}" in caplog.text
    assert not list(files.target.glob(".*"))


def test_so_does_a_run_with_a_sun(files, tmp_path, monkeypatch, caplog):
    """Its shadows are as old as 8 iterations, so some are older than the checkpoint."""
    caplog.set_level("INFO", "r3gw")
    settings = json.loads(files.settings.read_text())
    settings["daylight"] |= {"enabled": True, "shadow_age": 20_000, "reach_age": 15_000}
    settings["occlusion"] |= {"enabled": True, "first": 5_000, "interval": 20_000}
    files.settings.write_text(json.dumps(settings))
    killed(files, monkeypatch)
    assert go(files) == undisturbed(files, tmp_path / "other")
    assert f"at iteration {KILLED_AT}" in caplog.text


@pytest.mark.parametrize("tied_from", [15_000, 30_000])
def test_so_does_a_run_whose_suns_are_known(files, tmp_path, monkeypatch, caplog, tied_from):
    """They are tied after iteration 6, which the checkpoint knows of, or 12."""
    caplog.set_level("INFO", "r3gw")
    settings = json.loads(files.settings.read_text())
    settings["daylight"] |= {"enabled": True, "suns": "known", "suns_tied_from": tied_from}
    settings["occlusion"] |= {"enabled": True, "first": 5_000, "interval": 20_000}
    files.settings.write_text(json.dumps(settings))
    scene = json.loads((files.scene / "scene.json").read_text())
    for view, azimuth_deg in zip(scene["views"], (120.0, 200.0, 250.0, 300.0), strict=False):
        view["sun"] = {"azimuth_deg": azimuth_deg, "elevation_deg": 35.0}
    (files.scene / "scene.json").write_text(json.dumps(scene))
    checkpoint = killed(files, monkeypatch)
    kept = read_arrays(checkpoint, "checkpoint")[1]["tied_suns"]
    assert (kept["yaw_deg"] is not None) == (tied_from == 15_000)
    assert go(files) == undisturbed(files, tmp_path / "other")
    assert f"at iteration {KILLED_AT}" in caplog.text
    record, other = (
        json.loads((folder / "run.json").read_text())["known_suns"]
        for folder in (files.target, tmp_path / "other")
    )
    assert record == other
    assert set(record["known"]) == {"0", "1"}


def test_so_does_a_run_that_looks_for_occluders(files, tmp_path, monkeypatch, caplog):
    """They are found after iterations 4 and 12: those of the checkpoint are used until then.

    A photo of the two hardly differs from its rendering at so low a contrast, or everywhere.
    """
    caplog.set_level("INFO", "r3gw")
    settings = json.loads(files.settings.read_text())
    settings["occluders"] |= {"enabled": True, "first": 10_000, "interval": 20_000}
    settings["occluders"] |= {"contrast": 1e-6, "most": 0.3}
    files.settings.write_text(json.dumps(settings))
    monkeypatch.setattr(occluders, "FEWEST_PHOTOS", 1)
    monkeypatch.setattr(occluders, "USUAL_FACTOR", 0.5)
    checkpoint = killed(files, monkeypatch)
    tensors, _ = read_arrays(checkpoint, "checkpoint")
    assert tensors["occluder.0"].any()
    assert go(files) == undisturbed(files, tmp_path / "other")
    assert f"at iteration {KILLED_AT}" in caplog.text
    view = load_scene(files.scene).split("train")[0]
    mask, other = (load_found(run, view) for run in (files.target, tmp_path / "other"))
    assert 0.0 < mask.mean() < 0.6
    assert (mask == other).all()


def test_masks_of_occluders_go_with_the_run_that_found_them(files):
    settings = json.loads(files.settings.read_text())
    found = files.target / "is_occluder"
    files.settings.write_text(json.dumps(settings | {"occluders": ALWAYS}))
    go(files)
    assert sorted(path.stem for path in found.iterdir()) == sorted(TRAIN)
    files.settings.write_text(json.dumps(settings))
    go(files)
    assert not found.exists()


@pytest.mark.parametrize("changed", EDITS)
def test_a_checkpoint_of_other_inputs_is_not_continued(
    files, checkpoint, tmp_path, caplog, changed
):
    EDITS[changed](files)
    assert go(files) == undisturbed(files, tmp_path / "other")
    assert f"{checkpoint} is not continued: it was made of other {changed.strip()}" in caplog.text
    assert not list(files.target.glob(".*"))


def test_a_checkpoint_of_other_code_is_not_continued(files, checkpoint, monkeypatch, caplog):
    monkeypatch.setattr(run, "_code", lambda: "other")
    go(files)
    assert f"{checkpoint} is not continued: it was made of other code" in caplog.text


def test_a_checkpoint_of_other_threads_is_not_continued(files, checkpoint, tmp_path, caplog):
    assert go(files, num_threads=2) == undisturbed(files, tmp_path / "other", num_threads=2)
    assert f"{checkpoint} is not continued: it was made of other threads" in caplog.text


def test_a_checkpoint_of_other_settings_is_not_continued(files, checkpoint, caplog):
    values = json.loads(files.settings.read_text())
    files.settings.write_text(json.dumps(values | {"seed": 1}))
    go(files)
    assert f"{checkpoint} is not continued: it was made of other settings" in caplog.text


@pytest.mark.parametrize("kept", [0, 4, 700, 0.5, 0.99])
def test_a_damaged_checkpoint_is_named_and_training_starts_afresh(
    files, checkpoint, tmp_path, caplog, kept
):
    content = checkpoint.read_bytes()
    checkpoint.write_bytes(content[: kept if isinstance(kept, int) else int(kept * len(content))])
    assert go(files) == undisturbed(files, tmp_path / "other")
    assert f"{checkpoint} is not continued, training starts afresh" in caplog.text


def test_fresh_looks_at_no_checkpoint(files, checkpoint, caplog):
    caplog.set_level("INFO", "r3gw")
    go(files, fresh=True)
    assert "continu" not in caplog.text
    assert not checkpoint.exists()


def test_the_record_says_what_the_run_depends_on(files):
    go(files)
    record = json.loads((files.target / "run.json").read_text())
    assert set(record["depends_on"]) == {
        "settings", "code", "photos", "masks", "initial points", "threads",
    }  # fmt: skip
    first = record["run_digest"]
    edit_mask(files)
    go(files)
    after = json.loads((files.target / "run.json").read_text())
    changed = {k for k, v in after["depends_on"].items() if v != record["depends_on"][k]}
    assert changed == {"masks"}
    assert after["run_digest"] != first


def test_a_longer_run_says_why_it_starts_anew(files, caplog):
    go(files)
    values = json.loads(files.settings.read_text())
    files.settings.write_text(json.dumps(values | {"iterations": 2 * ITERATIONS}))
    go(files)
    assert f"of {ITERATIONS} iterations is not lengthened to {2 * ITERATIONS}" in caplog.text


def test_a_missing_input_is_a_sentence(files):
    files.initial.unlink()
    with pytest.raises(InputError, match=r"initial\.npz: no such file"):
        go(files)


def test_snapshots_are_the_run_on_its_way_and_change_nothing(files, tmp_path):
    plain = undisturbed(files, tmp_path)
    assert go(files, snapshots=(KILLED_AT, ITERATIONS)) == plain
    folder = files.target / "snapshots"
    assert sorted(path.name for path in folder.iterdir()) == [str(KILLED_AT), str(ITERATIONS)]
    assert (folder / str(ITERATIONS) / "model.safetensors").read_bytes() == plain
    early = folder / str(KILLED_AT)
    assert json.loads((early / "run.json").read_text())["iterations"] == KILLED_AT
    assert (early / "model.safetensors").read_bytes() != plain
    rows = (early / "history.csv").read_text().splitlines()
    final = (files.target / "history.csv").read_text().splitlines()
    assert rows == final[: KILLED_AT + 1]


def test_a_snapshot_that_cannot_be_written_costs_the_run_nothing(files, tmp_path, caplog):
    plain = undisturbed(files, tmp_path)
    files.target.mkdir(exist_ok=True)
    (files.target / "snapshots").write_text("a file where a folder should be")
    assert go(files, snapshots=(KILLED_AT,)) == plain
    assert "is not written" in caplog.text
