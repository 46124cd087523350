"""A protocol that is added to the list finds its way into every table and picture by itself."""

import json

import numpy as np
import pandas as pd
import pytest
from support.made_up_runs import RED, make_run, make_scene, plain

from r3gw.evaluation.protocols import facts
from r3gw.evaluation.protocols.facts import ProtocolFacts
from r3gw.evaluation.protocols.registry import PROTOCOLS
from r3gw.imaging.files import read_rgb, write_image
from r3gw.reporting.figures.grids import view_grid
from r3gw.reporting.figures.plots import study_plot
from r3gw.reporting.figures.style import look
from r3gw.reporting.page.scene_page import SceneFolders
from r3gw.reporting.page.stage import write_report
from r3gw.reporting.runs import load_run
from r3gw.reporting.tables.stage import write_ablation_tables, write_main_tables
from r3gw.reporting.tables.study import study_table
from r3gw.scene import load_scene

DUSK = ProtocolFacts(
    name="dusk",
    suffix="_dusk",
    title="the sun just set",
    light_title="dusk",
    rank=-1,
    extra_fields=("bats",),
    is_pictured=True,
    study_metrics=("psnr",),
)


@pytest.fixture
def results(tmp_path, monkeypatch):
    """A made-up scene with two runs that were scored at dusk too."""
    monkeypatch.setattr(facts, "PROTOCOLS", (*facts.PROTOCOLS, DUSK))
    make_scene(tmp_path / "x" / "scene", with_test=True)
    for psnr, variant in ((12.0, "full"), (11.0, "no_specular")):
        run = make_run(tmp_path / "x" / variant / "seed0", variant, with_test=True)
        path = run / "metrics" / "metrics.json"
        content = json.loads(path.read_text())
        figures = {"psnr": psnr, "ssim": 0.5, "mse": 0.1, "mae": 0.2, "bats": 3.0}
        content["images"].append({"view": "v", "protocol": "dusk", **figures})
        path.write_text(json.dumps(content))
        write_image(run / "metrics" / "renders" / "dusk" / "v.png", plain(RED))
    return tmp_path


def metrics_files(results):
    return [results / "x" / name / "seed0/metrics/metrics.json" for name in ("full", "no_specular")]


def test_it_has_columns_and_a_panel_in_table1(results):
    write_main_tables(metrics_files(results), None, results)
    row = pd.read_csv(results / "table1.csv").iloc[0]
    assert (row.psnr_dusk_x, row.mae_dusk_avg) == (12.0, 0.2)
    assert "**Protocol dusk: the sun just set**" in (results / "table1.md").read_text()
    assert "protocol dusk: the sun just set" in (results / "table1.tex").read_text()


def test_it_has_rows_of_images_and_figures_of_runs(results):
    write_main_tables(metrics_files(results), None, results)
    images = pd.read_csv(results / "images.csv")
    assert list(images[images.protocol == "dusk"].psnr) == [12.0, 11.0]
    assert list(pd.read_csv(results / "runs.csv").bats_dusk) == [3.0, 3.0]
    write_ablation_tables(metrics_files(results), results)
    assert list(pd.read_csv(results / "ablations.csv").ssim_dusk_avg) == [0.5, 0.5]


def test_it_shows_views_first_as_its_rank_says(results):
    runs = [load_run(path) for path in metrics_files(results)]
    assert runs[0].protocol_of("v") == "dusk"
    folder = results / "x" / "scene"
    with look():
        figure = view_grid(load_scene(folder), folder, runs)
    titles = [text.get_text() for text in figure.texts]
    assert titles[1:5] == ["photo", "full\ndusk", "its error", "full\nnerf-osr"]
    figure.savefig(results / "views.png", dpi=100)
    assert (read_rgb(results / "views.png").reshape(-1, 3) == RED).all(axis=1).mean() > 0.1


def test_it_stands_in_the_report_and_in_studies(results):
    write_main_tables(metrics_files(results), None, results)
    runs = tuple(path.parents[1] for path in metrics_files(results))
    write_report(results, [SceneFolders(results / "x", runs)], results / "report.html")
    page = (results / "report.html").read_text()
    assert "protocol dusk: the sun just set" in page
    assert "dusk: 12.00 dB, SSIM 0.500" in page
    table = study_table(metrics_files(results), "full", results / "study.csv")
    assert list(table.gain_psnr_dusk_avg) == [0.0, -1.0]
    assert "| PSNR, dusk " in (results / "study.md").read_text()
    assert [axes.get_ylabel() for axes in study_plot(table, "full").axes] == [
        "PSNR, dusk (dB)",
        "PSNR, nerf-osr (dB)",
    ]


def test_protocols_do_not_share_names_columns_or_ranks():
    for field in ("name", "suffix", "title", "light_title", "rank"):
        values = [getattr(protocol, field) for protocol in facts.PROTOCOLS]
        assert len(set(values)) == len(values), field
    assert np.isfinite([protocol.rank for protocol in facts.PROTOCOLS]).all()


def test_every_protocol_that_tables_know_is_scored_by_one_class():
    assert [protocol.facts for protocol in PROTOCOLS] == list(facts.PROTOCOLS)
