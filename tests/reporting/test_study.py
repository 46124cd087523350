"""r3gw.reporting.tables.study against means, gains and spreads worked out by hand."""

import json
from pathlib import Path

import pandas as pd
import pytest

from r3gw.files import InputError
from r3gw.imaging.files import read_rgb
from r3gw.reporting.changes import Change, changes
from r3gw.reporting.figures.plots import study_plot
from r3gw.reporting.figures.stage import write_study
from r3gw.reporting.tables.study import study_table

SETTINGS = {"iterations": 100, "seed": 0, "density": {"reset_interval": None, "first": 5}}


def write_run(
    folder: Path, scene: str, variant: str, seed: int, psnr: float, seconds: float, **changes: int
) -> Path:
    """A run with one test view, 1 dB worse under nerf-osr than under the true light."""
    root = folder / scene / variant / f"seed{seed}"
    (root / "metrics").mkdir(parents=True)
    records = [
        {"view": view, "protocol": protocol, "psnr": psnr + more, "ssim": psnr / 100}
        | {"mse": 0.01, "mae": 0.05}
        for view, protocol, more in (("v", "exact", 0), ("v", "nerf-osr", -1), ("t", "learned", 2))
    ]
    run = {
        "scene": scene, "variant": variant, "seed": seed, "iterations": 100,
        "num_foreground": 900 + 100 * seed,
        "num_sky": 100, "num_threads": 1, "settings_digest": f"digest{variant}",
        "code_version": "0.1.0", "machine": "m",
    }  # fmt: skip
    path = root / "metrics" / "metrics.json"
    path.write_text(json.dumps({"run": run, "images": records, "decomposition": []}))
    cost = {"training_seconds": seconds, "training_peak_rss_mb": 500.0}
    path.with_name("cost.json").write_text(json.dumps(cost))
    (root / "settings.json").write_text(json.dumps(SETTINGS | {"seed": seed} | changes))
    return path


@pytest.fixture
def files(tmp_path) -> list[Path]:
    """Two scenes, two seeds; `long` is half as long again, 2 dB better on one scene only."""
    rows = [
        ("chapel", "full", 0, 20.0, 10.0),
        ("chapel", "full", 1, 22.0, 14.0),
        ("chapel", "long", 0, 22.0, 15.0),
        ("chapel", "long", 1, 24.0, 21.0),
        ("arcade", "full", 0, 16.0, 10.0),
        ("arcade", "full", 1, 16.0, 14.0),
        ("arcade", "long", 0, 16.0, 15.0),
        ("arcade", "long", 1, 16.5, 21.0),
    ]
    more = {"full": {}, "long": {"iterations": 150}}
    return [write_run(tmp_path, *row, **more[row[1]]) for row in rows]


def write_all(files: list[Path], folder: Path) -> None:
    """Tables and plot of a study, all in one folder."""
    write_study(
        files, "full", folder / "study.csv", folder / "study_runs.csv", folder / "study.png"
    )


def test_gain_is_the_difference_of_averages_over_scenes(files, tmp_path):
    study_table(files, "full", tmp_path / "study.csv")
    table = pd.read_csv(tmp_path / "study.csv").set_index("variant")
    full, long = table.loc["full"], table.loc["long"]
    # full: chapel 21, arcade 16; long: chapel 23, arcade 16.25.
    assert (full.psnr_exact_avg, full.psnr_avg, full.psnr_learned_avg) == (18.5, 17.5, 20.5)
    assert long.psnr_exact_avg == pytest.approx(19.625, rel=1e-5, abs=0)
    assert long.ssim_exact_avg == pytest.approx(0.19625, rel=1e-5, abs=0)
    for figure in ("psnr_exact", "psnr", "psnr_learned"):
        assert full[f"gain_{figure}_avg"] == 0.0
        assert long[f"gain_{figure}_avg"] == pytest.approx(1.125, rel=1e-5, abs=0)
    assert (full.training_seconds_mean, long.training_seconds_mean) == (12.0, 18.0)
    assert full.num_gaussians_mean == 1050
    assert (full.seeds, full.settings_digest) == ("0;1", "digestfull")


def test_spread_is_of_the_averages_per_seed(files, tmp_path):
    table = study_table(files, "full", tmp_path / "study.csv").set_index("variant")
    # full: 18 and 19; long: 19 and 20.25. The sample's spread of two is their distance over √2.
    assert table.loc["full", "psnr_exact_std_avg"] == pytest.approx(1 / 2**0.5, rel=1e-9, abs=0)
    assert table.loc["long", "psnr_exact_std_avg"] == pytest.approx(1.25 / 2**0.5, rel=1e-9, abs=0)


def test_seconds_stand_beside_psnr(files, tmp_path):
    columns = list(study_table(files, "full", tmp_path / "study.csv").columns)
    assert columns[:4] == ["variant", "change", "training_seconds_mean", "psnr_exact_avg"]
    lines = (tmp_path / "study.md").read_text().splitlines()
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in (lines[0], lines[3])]
    row = dict(zip(*cells, strict=True))
    assert row["Change"] == "iterations 100 → 150"
    assert (row["Training (s)"], row["Gaussians"]) == ("18.0", "1,050")
    assert row["PSNR, true light"] == "19.62 (0.88)"
    assert (row["Gain, true light"], row["Gain, nerf-osr"]) == ("+1.12", "+1.12")


def test_a_loss_has_a_minus(files, tmp_path):
    study_table(files, "long", tmp_path / "study.csv")
    assert "| −1.12 " in (tmp_path / "study.md").read_text()


def test_changes_are_read_from_the_settings():
    after = {"iterations": 100, "seed": 3, "density": {"reset_interval": 3000, "first": 5}}
    assert changes(SETTINGS, after) == [Change("density.reset_interval", "null", "3000")]
    assert changes(SETTINGS, SETTINGS | {"iterations": 5, "new": "x"}) == [
        Change("iterations", "100", "5"),
        Change("new", "absent", "x"),
    ]
    assert changes(SETTINGS, SETTINGS | {"seed": 9}) == []


def test_a_variant_that_lacks_a_scene_has_no_average_and_no_gain(files, tmp_path):
    study_table(files[:6], "full", tmp_path / "study.csv")
    long = pd.read_csv(tmp_path / "study.csv").set_index("variant").loc["long"]
    assert pd.isna(long.psnr_exact_avg)
    assert pd.isna(long.gain_psnr_exact_avg)
    assert (tmp_path / "study.md").read_text().count("nan") == 0


def test_every_variant_is_drawn_at_its_seconds_and_psnr(files, tmp_path):
    table = study_table(files, "full", tmp_path / "study.csv")
    exact, published = study_plot(table, "full").axes
    drawn = {
        errorbar.get_label(): (*errorbar.lines[0].get_xydata()[0],) for errorbar in exact.containers
    }
    assert drawn == {"full": (12.0, 18.5), "long": (18.0, 19.625)}
    assert published.containers[1].lines[0].get_ydata()[0] == 18.625
    write_all(files, tmp_path)
    assert read_rgb(tmp_path / "study.png").shape[1] > 1000
    assert (tmp_path / "study.pdf").read_bytes().startswith(b"%PDF")


def test_same_files_give_the_same_bytes(files, tmp_path):
    for name in ("a", "b"):
        write_all(files, tmp_path / name)
    for suffix in ("csv", "md", "png", "pdf"):
        first, second = (tmp_path / name / f"study.{suffix}" for name in ("a", "b"))
        assert first.read_bytes() == second.read_bytes()


def test_bad_input_is_named(files, tmp_path):
    with pytest.raises(InputError, match="no run is of the study's baseline 'fool', there are ful"):
        study_table(files, "fool", tmp_path / "t.csv")
    settings = files[0].parent.with_name("settings.json")
    settings.write_text("{")
    with pytest.raises(InputError, match=r"settings\.json: not readable as JSON"):
        study_table(files[:1], "full", tmp_path / "t.csv")
    settings.unlink()
    with pytest.raises(InputError, match=r"settings\.json: no such file; train the run again"):
        study_table(files[:1], "full", tmp_path / "t.csv")
