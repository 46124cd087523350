"""r3gw.evaluation.stage: the stage from files to files."""

import json
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest
import torch

from r3gw.evaluation.stage import evaluate_run
from r3gw.files import InputError
from r3gw.imaging.files import read_linear, read_rgb
from r3gw.lighting import sh


@dataclass(frozen=True)
class Done:
    """What one evaluation of the tiny scene left, and how long it took."""

    folder: Path
    seconds: float


@pytest.fixture(scope="module")
def done(tiny, tmp_path_factory) -> Done:
    folder, start = tmp_path_factory.mktemp("metrics"), perf_counter()
    evaluate_run(tiny.folder, tiny.masks, tiny.model_path, folder, num_threads=1)
    return Done(folder, perf_counter() - start)


def test_writes_records_lights_and_pictures(tiny, done):
    target = done.folder
    content = json.loads((target / "metrics.json").read_text())
    assert content["run"]["variant"] == "full"
    images = {(r["view"], r["protocol"]): r for r in content["images"]}
    assert set(images) == {
        ("b_exact", "nerf-osr"),
        ("b_exact", "exact"),
        ("c_swept", "nerf-osr"),
        ("b_exact", "full-yaw"),
        ("c_swept", "full-yaw"),
        ("b_exact", "nerf-osr-linear"),
        ("c_swept", "nerf-osr-linear"),
        ("b_exact", "half-image"),
        ("c_swept", "half-image"),
        ("a_0", "learned"),
        ("a_1", "learned"),
    }
    assert images["c_swept", "nerf-osr"]["psnr"] > 50
    assert images["b_exact", "exact"]["scene"] == "tiny"
    assert {r["view"] for r in content["decomposition"]} == {"b_exact", "a_0", "a_1"}
    renders = target / "renders"
    for kind in ("nerf-osr", "exact", "albedo", "normal", "depth", "sky", "foreground"):
        assert (renders / kind / "b_exact.png").is_file()
    assert {path.stem for path in (renders / "learned").iterdir()} == {"a_0", "a_1"}
    photo = read_rgb(tiny.folder / "images" / "b_exact.png")
    difference = read_rgb(renders / "exact/b_exact.png").astype(int) - photo
    assert np.abs(difference).max() <= 1
    # The wall stands 6 in front of every camera.
    depth = read_linear(target / "renders/depth/b_exact.exr")
    np.testing.assert_allclose(np.median(depth[20:, :, 0]), 6.0, rtol=0.02, atol=0)


def test_every_image_has_a_file_of_its_own(done):
    whole = json.loads((done.folder / "metrics.json").read_text())
    files = list(done.folder.glob("images/*/*.json"))
    assert len(files) == len(whole["images"])
    for record in whole["images"]:
        path = done.folder / "images" / record["protocol"] / f"{record['view']}.json"
        assert json.loads(path.read_text()) == {**record, "run": whole["run"]}
        assert record["protocol_version"] == 1
        # Two photos stand 0.3 apart, 6 before the wall; test views look at it beside them.
        assert 0.8 < record["well_seen"] <= 1


def test_cost_is_measured(tiny, done):
    cost = json.loads((done.folder / "cost.json").read_text())
    assert 30 / cost["renders_per_second"] < done.seconds
    assert cost["render_megapixels"] == pytest.approx(48 * 32 / 1e6, rel=1e-9, abs=0)
    assert cost["render_threads"] == 1
    assert 50 < cost["peak_rss_mb"] < 20_000
    trained = json.loads(tiny.model_path.with_name("timing.json").read_text())
    assert cost["training_seconds"] == trained["training_seconds"]
    assert cost["training_peak_rss_mb"] == trained["peak_rss_mb"]


@pytest.mark.slow
def test_a_training_of_the_same_model_that_took_longer_changes_cost_alone(tiny, tmp_path):
    run = tiny.model_path.with_name("run.json").read_text()
    for name, seconds in (("one", 10.0), ("two", 20.0)):
        folder = tmp_path / name
        folder.mkdir()
        model = folder / tiny.model_path.name
        model.write_bytes(tiny.model_path.read_bytes())
        slower = {"training_seconds": seconds, "peak_rss_mb": 20 * seconds}
        (folder / "run.json").write_text(run)
        (folder / "timing.json").write_text(json.dumps(slower))
        evaluate_run(tiny.folder, tiny.masks, model, folder / "metrics", num_threads=1)
    one, two = (tmp_path / name / "metrics" for name in ("one", "two"))
    for path in (path for path in one.rglob("*.*") if path.name != "cost.json"):
        assert path.read_bytes() == (two / path.relative_to(one)).read_bytes(), path.name
    costs = [json.loads((folder / "cost.json").read_text()) for folder in (one, two)]
    assert [cost["training_seconds"] for cost in costs] == [10.0, 20.0]


def test_lights_are_those_of_the_model(tiny, done):
    content = json.loads((done.folder / "lights.json").read_text())
    assert (content["format"], content["coordinates"]) == ("r3gw-lights", "scene")
    lights = content["photos"]
    light, sky = tiny.model.appearance(1)[:2]
    torch.testing.assert_close(torch.tensor(lights["a_1"]["light"]), light, rtol=1e-6, atol=1e-7)
    torch.testing.assert_close(torch.tensor(lights["a_1"]["sky"]), sky, rtol=1e-6, atol=1e-7)
    assert len(lights["a_0"]["light"]) == sh.num_coefficients(4)


def test_missing_run_record_and_model_are_named(tiny, tmp_path):
    model = tmp_path / "model.safetensors"
    with pytest.raises(InputError, match=r"run\.json: no such file; train"):
        evaluate_run(tiny.folder, tiny.masks, model, tmp_path, num_threads=1)
    (tmp_path / "run.json").write_text('{"scene": "tiny"}')
    with pytest.raises(InputError, match=r"timing\.json: no such file; train"):
        evaluate_run(tiny.folder, tiny.masks, model, tmp_path, num_threads=1)
    (tmp_path / "timing.json").write_text("{}")
    with pytest.raises(InputError, match=r"model\.safetensors: no such model"):
        evaluate_run(tiny.folder, tiny.masks, model, tmp_path, num_threads=1)
