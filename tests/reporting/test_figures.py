"""r3gw.reporting figures: the right picture in the right place, and the same bytes again."""

import json
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest

from r3gw.files import InputError
from r3gw.geometry.similarity import Similarity
from r3gw.imaging.files import write_exr, write_image
from r3gw.reporting.figures import scene_figures
from r3gw.reporting.style import Cell, look, picture_grid, save
from r3gw.scene import Scene, View, save_scene
from r3gw.scene.scene import Gauge

RED, GREEN, BLUE = (255, 0, 0), (0, 255, 0), (0, 0, 255)


def plain(colour: tuple[int, int, int]) -> np.ndarray:
    """A picture of one colour, 12x16."""
    return np.full((12, 16, 3), colour, np.uint8)


def view(name: str, split: str) -> View:
    """A view of no particular camera."""
    return View(
        name=name,
        image=f"images/{name}.png",
        width=16,
        height=12,
        intrinsics=(10.0, 10.0, 8.0, 6.0),
        cam_from_world=((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
        split=split,
        session="s",
    )


def make_scene(folder: Path, *, with_test: bool) -> Path:
    """A scene of one training view and, if asked for, one test view."""
    views = [view("t", "train")] + ([view("v", "test")] if with_test else [])
    gauge = Gauge.of(Similarity.identity())
    scene = Scene(name="x", source_format="photos", views=tuple(views), scene_from_source=gauge)
    save_scene(scene, folder)
    for each in views:
        write_image(folder / each.image, plain(GREEN))
    return folder


def make_run(folder: Path, variant: str, *, with_test: bool) -> Path:
    """An evaluated run's folder with pictures of one colour."""
    renders = folder / "metrics" / "renders"
    records = [{"view": "t", "protocol": "learned", "psnr": 25.0}]
    if with_test:
        sweep = {"sweep_angles_rad": [0.0, 0.5, 1.0], "sweep_psnr": [1.0, 3.0, 2.0]}
        records.append(
            {"view": "v", "protocol": "nerf-osr", "psnr": 3.0, "angle_rad": 0.5, **sweep}
        )
    for record in records:
        name = record["view"]
        for kind in ("truth", "albedo", "normal", "sky", "foreground", record["protocol"]):
            write_image(renders / f"{name}_{kind}.png", plain(BLUE))
        write_exr(renders / f"{name}_depth.exr", np.full((12, 16, 3), 5.0, np.float32))
    content = {"run": {"variant": variant}, "images": records, "decomposition": []}
    (folder / "metrics" / "metrics.json").write_text(json.dumps(content))
    lights = {"t": {"light": [[1.0, 0.5, 0.2]] * 4, "sky": [[0.0] * 3] * 4}}
    (folder / "metrics" / "lights.json").write_text(json.dumps(lights))
    columns = ("iteration", "loss", "psnr", "num_foreground", "num_sky")
    history = {name: [1.0, 2.0, 3.0] for name in columns}
    pd.DataFrame(history).to_csv(folder / "history.csv", index=False)
    return folder


def test_grid_puts_every_picture_in_its_place(tmp_path):
    rows = [[Cell(plain(RED)), Cell(plain(GREEN))], [None, Cell(plain(BLUE))]]
    with look():
        figure = picture_grid(rows, ["a", "b"], ["1", "2"], cell_width_in=1.0)
        save(figure, tmp_path / "grid.png", as_pdf=False)
    image = cv2.imread(str(tmp_path / "grid.png"))[..., ::-1]
    # 200 dots per inch; margins of 0.3 in at the left and top; cells 1 x 0.75 in, 0.04 in apart.
    for (x_in, y_in), colour in {
        (0.8, 0.675): RED,
        (1.84, 0.675): GREEN,
        (0.8, 1.465): (255, 255, 255),
        (1.84, 1.465): BLUE,
    }.items():
        assert tuple(image[round(200 * y_in), round(200 * x_in)]) == colour
    assert image.shape[:2] == (376, 476)


def test_all_figures_of_a_scene_with_test_views(tmp_path):
    scene = make_scene(tmp_path / "scene", with_test=True)
    runs = [make_run(tmp_path / v, v, with_test=True) for v in ("full", "no_specular")]
    scene_figures("x", scene, runs, tmp_path / "figures")
    assert {path.name for path in (tmp_path / "figures").iterdir()} == {
        "x_views.png",
        "x_decomposition.png",
        "x_lights.png",
        "x_training.png",
        "x_training.pdf",
        "x_sweep.png",
        "x_sweep.pdf",
    }


def test_photos_alone_show_training_views(tmp_path):
    scene = make_scene(tmp_path / "scene", with_test=False)
    run = make_run(tmp_path / "full", "full", with_test=False)
    scene_figures("x", scene, [run], tmp_path / "figures")
    names = {path.name for path in (tmp_path / "figures").iterdir()}
    assert "x_sweep.png" not in names
    image = cv2.imread(str(tmp_path / "figures" / "x_views.png"))[..., ::-1]
    assert (image.reshape(-1, 3) == BLUE).all(axis=1).mean() > 0.5  # photo and render


def test_same_runs_give_the_same_bytes(tmp_path):
    scene = make_scene(tmp_path / "scene", with_test=True)
    run = make_run(tmp_path / "full", "full", with_test=True)
    for target in ("one", "two"):
        scene_figures("x", scene, [run], tmp_path / target)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes(), path.name


def test_missing_evaluation_is_named(tmp_path):
    scene = make_scene(tmp_path / "scene", with_test=False)
    with pytest.raises(InputError, match=r"metrics\.json: no such file; train and evaluate"):
        scene_figures("x", scene, [tmp_path / "nothing"], tmp_path)
    with pytest.raises(InputError, match="scene x need at least one run"):
        scene_figures("x", scene, [], tmp_path)
