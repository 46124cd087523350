"""The scene on disk: it comes back as it went, and damage is named."""

import json

import numpy as np
import pytest
import torch

from r3gw.files import InputError
from r3gw.geometry.similarity import Similarity
from r3gw.scene import Gauge, Points, Scene, View, load_points, load_scene, save_points, save_scene


def view(name, split="train"):
    pose = np.eye(4)
    pose[:3, 3] = (0.1, 1 / 3, -2e-17)
    return View(
        name=name,
        image=f"images/{name}.png",
        width=8,
        height=6,
        intrinsics=(7.0, 7.5, 4.0, 3.0),
        cam_from_world=tuple(map(tuple, pose.tolist())),
        split=split,
        session=None,
    )


def scene():
    turn = torch.linalg.qr(torch.arange(9, dtype=torch.float64).reshape(3, 3).cos())[0]
    gauge = Gauge.of(Similarity(0.3, turn, torch.tensor([1.0, 2.0, 3.0], dtype=torch.float64)))
    views = (view("b"), view("a", "test"), view("c"))
    return Scene(name="x", source_format="photos", views=views, scene_from_source=gauge)


def test_scene_comes_back_exactly_in_order_of_names(tmp_path):
    save_scene(scene(), tmp_path)
    loaded = load_scene(tmp_path)
    assert [v.name for v in loaded.views] == ["a", "b", "c"]
    assert [v.name for v in loaded.split("train")] == ["b", "c"]
    assert {v.name: v for v in loaded.views} == {v.name: v for v in scene().views}
    assert torch.equal(
        loaded.scene_from_source.similarity.rotation, scene().scene_from_source.similarity.rotation
    )
    assert loaded.views[0].camera.cam_from_world[1, 3] == 1 / 3


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"veiws": []}, "unknown key 'veiws'; did you mean 'views'"),
        ({"views": [{"name": "a"}]}, r"key 'views\.0\.image' is missing"),
    ],
)
def test_damaged_scene_is_named(tmp_path, change, sentence):
    save_scene(scene(), tmp_path)
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(InputError, match=sentence):
        load_scene(tmp_path)


def test_points_come_back_exactly(tmp_path):
    rng = np.random.default_rng(0)
    points = Points(
        rng.normal(size=(9, 3)).astype(np.float32), rng.integers(0, 256, (9, 3), dtype=np.uint8)
    )
    save_points(points, tmp_path)
    loaded = load_points(tmp_path)
    assert np.array_equal(loaded.xyz, points.xyz)
    assert np.array_equal(loaded.rgb, points.rgb)
    with pytest.raises(InputError, match="import the scene again"):
        load_points(tmp_path / "elsewhere")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"image": "../../secret.png"}, r"names the file '\.\./\.\./secret\.png', which is not"),
        ({"image": "/etc/secret.png"}, r"names the file '/etc/secret\.png'"),
        ({"name": "../../out"}, r"'\.\./\.\./out' is no name of a view"),
        ({"name": "a/b"}, r"'a/b' is no name of a view"),
        ({"name": "c"}, r"two views have the same name"),
        ({"width": 10**6, "height": 10**6}, r"the camera of b .*is none"),
        ({"width": 0}, r"key 'views\.1\.width' has the value 0"),
    ],
)
def test_strangers_scene_may_not_lead_elsewhere(tmp_path, change, sentence):
    save_scene(scene(), tmp_path)
    path = tmp_path / "scene.json"
    content = json.loads(path.read_text())
    content["views"][1] |= change
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match=sentence):
        load_scene(tmp_path)
