"""r3gw behind NerfBaselines' interface, of which only the names are needed here."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
import torch

from r3gw.importing.source import SourcePoints
from r3gw.model.model_file import load_model

SHORT = {
    "iterations": 12,
    "density.interval": 80000,  # never
    "density.reset_interval": None,
    "sky.min_count": 50,
    "sky.max_count": 50,
}


class Cameras(SimpleNamespace):
    """Cameras as NerfBaselines has them: arrays with a row each."""

    def __len__(self):
        return len(self.poses)

    def __iter__(self):
        return (self.one(index) for index in range(len(self)))

    def one(self, index):
        return Cameras(
            poses=self.poses[index],
            intrinsics=self.intrinsics[index],
            image_sizes=self.image_sizes[index],
        )

    def item(self):
        return self


@pytest.fixture
def module(repository, monkeypatch):
    """The method's module, with a stand-in for the library that imports it."""
    stub = ModuleType("nerfbaselines")
    registered = {}
    stub.register = lambda spec: registered.update({spec["id"]: spec})
    stub.Method, stub.Cameras, stub.Dataset = object, object, dict
    monkeypatch.setitem(sys.modules, "nerfbaselines", stub)
    monkeypatch.syspath_prepend(str(repository / "integrations/nerfbaselines"))
    for name in ("r3gw_method", "r3gw_spec"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    import r3gw_method
    import r3gw_spec  # noqa: F401

    assert registered["r3gw"]["method_class"] == "r3gw_method:R3gwMethod"
    r3gw_method.settings_with(registered["r3gw"]["presets"]["short"])  # all its keys are known
    return r3gw_method


@pytest.fixture
def dataset(tiny):
    """The photos of the tiny scene, its cameras and points on its wall, in another frame."""
    views = [tiny.view(name) for name in ("a_0", "a_1", "b_exact")]
    world = [torch.linalg.inv(view.camera.cam_from_world).numpy()[:3] for view in views]
    xyz = tiny.model.foreground["means"].detach().numpy().astype(np.float64)
    return {
        "cameras": Cameras(
            poses=np.stack(world),
            intrinsics=np.array([view.intrinsics for view in views]),
            image_sizes=np.array([(view.width, view.height) for view in views]),
        ),
        "points3D_xyz": xyz * 3.0,
        "images": [tiny.evaluated.photo(view) for view in views],
        "image_paths": [f"images/{view.name}.png" for view in views],
        "masks": None,
    }


@pytest.fixture
def trained(module, dataset):
    dataset["images"] = [np.uint8(np.rint(255 * each)) for each in dataset["images"]]
    dataset["cameras"].poses[:, :, 3] *= 3.0
    method = module.R3gwMethod(train_dataset=dataset, config_overrides=SHORT)
    for step in range(12):
        method.train_iteration(step)
    return method


def test_a_saved_scene_renders_the_same(module, dataset, trained, tmp_path):
    camera = dataset["cameras"].one(1)
    options = {"embedding": trained.get_train_embedding(1)}
    picture = trained.render(camera, options=options)
    assert picture["color"].shape == (32, 48, 3)
    assert picture["accumulation"].max() > 0.5
    trained.save(str(tmp_path / "saved"))
    opened = module.R3gwMethod(checkpoint=str(tmp_path / "saved"))
    assert opened.get_info()["loaded_step"] == 12
    again = opened.render(camera, options=options)
    np.testing.assert_allclose(again["color"], picture["color"], rtol=0, atol=1e-6)


def test_a_fitted_light_suits_its_photo_better_than_the_mean_of_all(dataset, trained):
    photo = dataset["images"][2] / 255.0
    camera = dataset["cameras"].one(2)
    one = {"cameras": camera, "images": [dataset["images"][2]], "masks": None}
    embedding = trained.optimize_embedding(one)["embedding"]

    def error(options):
        return float(np.square(trained.render(camera, options=options)["color"] - photo).mean())

    assert error({"embedding": embedding}) < 0.9 * error(None)


def test_the_frame_keeps_cameras_and_points_together(module, dataset, trained):
    """A point of the dataset falls on the same pixel through either frame."""
    camera = dataset["cameras"].one(0)
    point = SourcePoints(dataset["points3D_xyz"][:1], np.zeros((1, 3), np.uint8)).xyz
    there = module.cam_from_source(camera.poses).numpy() @ np.append(point[0], 1.0)
    moved = trained._scene_from_source.points(torch.from_numpy(point))
    here = trained._camera(camera).cam_from_world.numpy() @ np.append(moved.numpy()[0], 1.0)
    np.testing.assert_allclose(here[:2] / here[2], there[:2] / there[2], rtol=1e-9, atol=1e-9)


def test_what_is_saved_is_a_model_of_r3gw(trained, tmp_path):
    trained.save(str(tmp_path))
    assert load_model(tmp_path / "model.safetensors").photos == ("a_0", "a_1", "b_exact")
