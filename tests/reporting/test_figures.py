"""r3gw.reporting figures: the right picture in the right place, and the same bytes again."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from matplotlib import colormaps
from support.made_up_runs import BLUE, GREEN, RED, make_run, make_scene, plain

from r3gw.files import InputError
from r3gw.reporting.figures.comparisons import busiest_window
from r3gw.reporting.figures.grids import absolute_error
from r3gw.reporting.figures.kinds import PICTURES, PLOTS
from r3gw.reporting.figures.stage import scene_figures
from r3gw.reporting.figures.style import Cell, Scale, look, picture_grid, save
from r3gw.reporting.figures.truth import depth_scale
from r3gw.reporting.runs import load_run
from r3gw.scene import load_scene

viridis = colormaps["viridis"]


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


def draw(root: Path, runs: list[Path], target: Path) -> set[str]:
    """Names of the figures of a made-up scene, without the scene's own."""
    scene_figures("x", root / "scene", root / "masks", runs, target)
    return {path.name.removeprefix("x_") for path in target.iterdir()}


@pytest.mark.slow
def test_all_figures_of_a_scene_with_test_views(tmp_path):
    make_scene(tmp_path / "scene", with_test=True)
    runs = [make_run(tmp_path / v, v, with_test=True) for v in ("full", "no_specular")]
    expected = {f"{kind}.png" for kind in (*PICTURES, *PLOTS, "sweep")}
    expected |= {f"{kind}.pdf" for kind in (*PLOTS, "sweep")}
    assert draw(tmp_path, runs, tmp_path / "figures") == expected


def test_photos_alone_show_training_views(tmp_path):
    make_scene(tmp_path / "scene", with_test=False)
    run = make_run(tmp_path / "full", "full", with_test=False)
    assert "sweep.png" not in draw(tmp_path, [run], tmp_path / "figures")
    image = cv2.imread(str(tmp_path / "figures" / "x_views.png"))[..., ::-1]
    photo, render = ((image.reshape(-1, 3) == c).all(axis=1).mean() for c in (GREEN, BLUE))
    assert photo > 0.2
    assert render > 0.2


def test_test_views_without_a_protocol_leave_the_place_to_training_views(tmp_path):
    make_scene(tmp_path / "scene", with_test=True)
    run = make_run(tmp_path / "full", "full", with_test=False)
    assert "views.png" in draw(tmp_path, [run], tmp_path / "figures")
    read = load_run(run / "metrics" / "metrics.json")
    assert [v.name for v in read.shown_views(load_scene(tmp_path / "scene"))] == ["t"]


@pytest.mark.slow
def test_same_runs_give_the_same_bytes(tmp_path):
    make_scene(tmp_path / "scene", with_test=True)
    run = make_run(tmp_path / "full", "full", with_test=True)
    for target in ("one", "two"):
        draw(tmp_path, [run], tmp_path / target)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes(), path.name


def test_missing_evaluation_is_named(tmp_path):
    make_scene(tmp_path / "scene", with_test=False)
    with pytest.raises(InputError, match=r"metrics\.json: no such file; train and evaluate"):
        draw(tmp_path, [tmp_path / "nothing"], tmp_path)
    with pytest.raises(InputError, match="scene x need at least one run"):
        draw(tmp_path, [], tmp_path)


def test_a_scale_colours_by_value_and_greys_the_unknown():
    scale = Scale("viridis", 1.0, 3.0, "depth")
    values = np.array([[0.0, 1.0, 2.0, 3.0, 9.0]])
    picture = scale.coloured(values, values > 0)
    expected = [
        (222, 222, 222),
        *(np.rint(255 * np.array(viridis(x)[:3])) for x in (0.0, 0.5, 1.0, 1.0)),
    ]
    np.testing.assert_allclose(picture[0], expected, rtol=0, atol=1)


def test_depth_scale_spans_all_maps_but_not_the_far_tail():
    near, far = np.full((10, 10), 2.0), np.full((10, 10), 6.0)
    far[0, :5] = 1000.0
    near[0] = 0.0  # unknown
    scale = depth_scale([near, far])
    assert (scale.low, scale.high) == (2.0, 6.0)


def test_window_prefers_an_outline_in_the_middle():
    band = np.zeros((100, 200), np.bool_)
    band[20:25, 80:120] = True
    band[70:77, :40] = True  # more pixels, but at the side
    left, top, width, height = busiest_window(band)
    assert (width, height) == (56, 28)
    assert left <= 80
    assert left + width >= 120
    assert top <= 20
    assert top + height >= 25


def test_absolute_error_by_hand():
    photo = plain((10, 20, 30))
    render = plain((40, 20, 0))
    np.testing.assert_allclose(absolute_error(render, photo), 60 / 3 / 255, rtol=1e-12, atol=0)
