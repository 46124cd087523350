"""The commands of the doctor: one line per problem, and no record where there is one."""

import json
import subprocess
import sys

import pytest
import yaml

from r3gw.pipeline.config import Config, run_settings
from r3gw.scene import load_scene

pytestmark = pytest.mark.slow


def test_command_exits_with_one_line_per_problem(configured, tmp_path, repository):
    configured.entry["path"] = "nowhere"
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(configured.values()))
    arguments = ["--config", "mine.yaml", "--target", "page"]
    arguments += ["--defaults", str(repository / "config")]
    done = subprocess.run(
        [sys.executable, "-m", "r3gw", "doctor", *arguments],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.strip().splitlines() == [
        "r3gw doctor: nowhere: no such file or folder; correct 'path' of scene 'place'"
    ]
    assert "A run would fail. 1 problem, 0 warnings." in done.stdout
    assert (tmp_path / "page" / "doctor.md").is_file()


def command(*arguments):
    line = [sys.executable, "-m", "r3gw", *arguments]
    return subprocess.run(line, capture_output=True, text=True, check=False)


def test_gate_before_the_import(configured):
    wanted = ["doctor-sources", "--entries"]
    assert command(*wanted, json.dumps({"place": configured.entry})).returncode == 0
    entries = {name: configured.entry | {"path": name} for name in ("nowhere", "elsewhere")}
    done = command(*wanted, json.dumps({"place": configured.entry} | entries))
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        f"r3gw doctor: {name}: no such file or folder; correct 'path' of scene '{name}'"
        for name in entries
    ]


def test_gate_before_the_training(made, tmp_path):
    target = tmp_path / "checked.json"
    wanted = ["doctor-scene", "--scene", "place", "--results", str(made.results)]
    assert command(*wanted, "--target", str(target)).returncode == 0
    record = json.loads(target.read_text())
    assert record["facts"]["polarity"] == "4 upright"
    assert record["size"]["foreground"] == 30
    assert (record["size"]["photos"], record["size"]["photo_pixels"]) == (3, 3 * 64 * 48)
    target.unlink()
    (made.masks / "is_sky" / f"{load_scene(made.scene).views[0].name}.png").unlink()
    done = command(*wanted, "--target", str(target))
    assert done.returncode == 1
    assert "no such picture" in done.stderr
    assert not target.exists()


@pytest.mark.parametrize(
    ("most", "status", "said"),
    [(10**4, 0, ""), (10**11, 1, "place/full/seed0: a training will need about 100000.4 GB but")],
)
def test_gate_of_a_run(configured, tmp_path, repository, most, status, said):
    size = {"foreground": 30, "sky": 100, "photos": 3, "photo_pixels": 9216}
    (tmp_path / "scene.json").write_text(json.dumps({"facts": {}, "size": size}))
    files = {f"{name}_file": repository / f"config/{name}.yaml" for name in ("train", "variants")}
    values = configured.values() | {"train": {"density": {"max_gaussians": most}}}
    settings = run_settings(Config.model_validate(values), "full", 0, **files)
    (tmp_path / "settings.json").write_text(settings.model_dump_json())
    arguments = ["doctor-run", "--name", "place/full/seed0"]
    arguments += ["--checked", tmp_path / "scene.json", "--settings", tmp_path / "settings.json"]
    done = command(*map(str, arguments))
    assert done.returncode == status
    assert said in done.stderr


def test_gate_of_a_run_needs_the_size_of_its_scene(tmp_path):
    (tmp_path / "scene.json").write_text("{}")
    arguments = ["--checked", "scene.json", "--settings", "settings.json"]
    line = [sys.executable, "-m", "r3gw", "doctor-run", "--name", "place/full/seed0", *arguments]
    done = subprocess.run(line, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode != 0
    assert "scene.json: holds no size of the scene; run doctor-scene again" in done.stderr
    assert "Traceback" not in done.stderr


def spoil_nothing(_):
    """The gate passes what the page passes."""


def spoil_photo(configured):
    (configured.scene / load_scene(configured.scene).views[0].image).write_bytes(b"no picture")


SPOILT = {
    "nothing": spoil_nothing,
    "photo": spoil_photo,
    "masks": lambda p: (p.masks / "masks.json").unlink(),
    "initial points": lambda p: (p.results / "place" / "initial.npz").unlink(),
}


@pytest.mark.parametrize("name", SPOILT)
def test_gate_of_a_scene_refuses_what_the_page_refuses(made, tmp_path, name):
    SPOILT[name](made)
    wanted = ["doctor-scene", "--scene", "place", "--results", str(made.results)]
    done = command(*wanted, "--target", str(tmp_path / "checked.json"))
    said = [f"r3gw doctor: {problem}" for problem in made.examine().problems]
    assert done.stderr.splitlines() == said
    assert done.returncode == (1 if said else 0)
    assert bool(said) == (name != "nothing")
