"""r3gw.reporting.tables.table1 against averages worked out by hand from small metrics files."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pandas as pd
import pytest

from r3gw.files import InputError
from r3gw.reporting.tables.listings import cost, decomposition, images_table, runs_table
from r3gw.reporting.tables.stage import write_main_tables
from r3gw.reporting.tables.table1 import ablations, table1


def record(view: str, protocol: str, psnr: float, **more: float) -> dict:
    """One image record; the other metrics follow from the PSNR, so that columns differ."""
    figures = {"psnr": psnr, "ssim": psnr / 100, "mse": psnr / 1000, "mae": psnr / 500}
    return {"scene": "-", "view": view, "protocol": protocol, **figures, **more}


def write_metrics(
    folder: Path, scene: str, variant: str, seed: int, psnrs: list[float], *, exact: bool = True
) -> Path:
    """metrics.json of a run whose test views have these PSNRs; exact is 1 dB lower."""
    images = [record(f"v{i}", "nerf-osr", psnr) for i, psnr in enumerate(psnrs)]
    if exact:
        images += [
            record(f"v{i}", "exact", psnr - 1, oracle_psnr=psnr + 5) for i, psnr in enumerate(psnrs)
        ]
    images.append(record("t0", "learned", 30.0, psnr_foreground=28.0))
    run = {
        "scene": scene,
        "variant": variant,
        "seed": seed,
        "iterations": 100,
        "settings_digest": f"digest{variant}{seed}",
        "code_version": "0.1.0+abc",
        "machine": "Some, processor (x86_64)",
        "num_threads": 2,
        "num_foreground": 1000,
        "num_sky": 200 + seed,
    }
    images += [record(f"v{i}", "full-yaw", psnr + 0.5) for i, psnr in enumerate(psnrs)]
    parts = [{"view": "v0", "albedo_psnr": 20.0 + seed}, {"view": "t0", "light_error": 0.25}]
    speed = {
        "renders_per_second": 40.0 + seed,
        "render_megapixels": 0.0432,
        "render_threads": 1,
        "peak_rss_mb": 300.0,
        "training_seconds": 10.0 + seed,
        "training_peak_rss_mb": 500.0 + seed,
    }
    path = folder / f"{scene}_{variant}_{seed}" / "metrics.json"
    path.parent.mkdir(exist_ok=True)
    path.with_name("cost.json").write_text(json.dumps(speed))
    path.write_text(json.dumps({"run": run, "images": images, "decomposition": parts}))
    return path


@pytest.fixture
def files(tmp_path) -> list[Path]:
    """Two scenes, two variants, two seeds."""
    return [
        write_metrics(tmp_path, scene, variant, seed, [base + 2 * seed, base + 4 + 2 * seed])
        for variant, shift in (("full", 0.0), ("no_specular", -3.0))
        for scene, base in (("chapel", 20.0 + shift), ("arcade", 16.0 + shift))
        for seed in (0, 1)
    ]


def read(path: Path) -> pd.DataFrame:
    """A table by method."""
    return pd.read_csv(path).set_index("method")


def test_table1_averages_views_then_seeds_then_scenes(files, tmp_path):
    table1(files, None, tmp_path / "table1.csv")
    table = read(tmp_path / "table1.csv")
    assert list(table.index) == ["r3gw", "r3gw without specular"]
    full = table.loc["r3gw"]
    # chapel: seeds (22, 24) -> 23; arcade: (18, 20) -> 19; average 21.
    assert (full.psnr_chapel, full.psnr_arcade, full.psnr_avg) == (23.0, 19.0, 21.0)
    assert (full.psnr_exact_chapel, full.psnr_exact_avg) == (22.0, 20.0)
    assert full.ssim_avg == pytest.approx(0.21, rel=1e-5, abs=0)
    assert full.mse_avg == pytest.approx(0.021, rel=1e-5, abs=0)
    assert full.mae_exact_avg == pytest.approx(0.04, rel=1e-5, abs=0)
    assert full.sweep_gain_psnr_avg == pytest.approx(1.0, rel=1e-5, abs=0)
    assert full.sweep_gain_psnr_arcade == pytest.approx(1.0, rel=1e-5, abs=0)
    assert full.full_yaw_gain_psnr_avg == pytest.approx(1.5, rel=1e-5, abs=0)
    assert full.psnr_full_yaw_avg == 21.5
    assert full.n_seeds == 2
    # Averages per seed are 20 and 22.
    assert full.psnr_std_avg == pytest.approx(2**0.5, rel=1e-5, abs=0)
    assert table.loc["r3gw without specular"].psnr_avg == 18.0
    assert list(table.group) == ["measured", "measured ablation"]


def test_table1_can_be_traced(files, tmp_path):
    table1(files, None, tmp_path / "table1.csv")
    full = read(tmp_path / "table1.csv").loc["r3gw"]
    assert full.settings_digest == "digestfull0;digestfull1"
    assert (full.seeds, full.code_version, full.iterations) == ("0;1", "0.1.0+abc", 100)
    assert (full.num_gaussians_mean, full.machine) == (1200.5, "Some, processor (x86_64)")


def test_same_files_give_the_same_bytes(files, tmp_path):
    for name in ("a", "b"):
        table1(files, None, tmp_path / name / "table1.csv")
    for suffix in ("csv", "md", "tex"):
        first, second = (tmp_path / n / f"table1.{suffix}" for n in ("a", "b"))
        assert first.read_bytes() == second.read_bytes()


def test_a_slower_machine_changes_the_table_of_cost_alone(files, tmp_path):
    write_main_tables(files, None, tmp_path / "before")
    for path in files:
        cost_file = path.with_name("cost.json")
        slower = {key: 2.5 * value for key, value in json.loads(cost_file.read_text()).items()}
        cost_file.write_text(json.dumps(slower))
    write_main_tables(files, None, tmp_path / "after")
    names = {path.name for path in (tmp_path / "before").iterdir()}
    assert names == {
        f"{name}.csv" for name in ("table1", "images", "runs", "decomposition", "cost")
    } | {
        "table1.md",
        "table1.tex",
    }
    for name in names:
        before, after = ((tmp_path / folder / name).read_bytes() for folder in ("before", "after"))
        assert (before == after) == (name != "cost.csv"), name


def test_markdown_has_a_table_per_protocol(files, tmp_path):
    table1(files, None, tmp_path / "table1.csv")
    blocks = (tmp_path / "table1.md").read_text().split("**Protocol ")[1:]
    assert [block.split(":")[0] for block in blocks] == ["nerf-osr", "full-yaw", "exact", "learned"]
    rows = [line.split("|")[1:-1] for line in blocks[2].splitlines() if line.startswith("|")]
    row = {head.strip(): cell.strip() for head, cell in zip(rows[0], rows[2], strict=True)}
    assert (row["Method"], row["PSNR chapel"]) == ("r3gw", "22.00 ± 1.41")
    assert (row["PSNR avg"], row["SSIM avg"]) == ("20.00 ± 1.41", "0.200 ± 0.014")


def test_latex_is_a_booktabs_tabular(files, tmp_path):
    table1(files, None, tmp_path / "table1.csv")
    latex = (tmp_path / "table1.tex").read_text()
    assert all(f"\\{name}rule\n" in latex for name in ("top", "mid", "bottom"))
    assert latex.count("\\begin{tabular}") == latex.count("\\end{tabular}") == 1
    columns = latex.split("\\begin{tabular}{")[1].split("}")[0]
    for line in latex.splitlines():
        if line.endswith("\\\\"):
            spans = [int(n) - 1 for n in re.findall(r"\\multicolumn\{(\d+)\}", line)]
            assert line.count("&") + 1 + sum(spans) == len(columns), line
    row = "r3gw & \\textbf{23.00} $\\pm$ 1.41 & \\textbf{0.230} $\\pm$ 0.014 & 0.023 $\\pm$ 0.001 &"
    assert row in latex
    body = latex.split("\n", 1)[1]
    assert "_" not in body.replace("\\_", "")


def test_one_seed_has_no_spread_and_no_mark(files, tmp_path):
    table1([path for path in files if path.parent.name.endswith("_0")], None, tmp_path / "t.csv")
    columns = pd.read_csv(tmp_path / "t.csv").columns
    assert [name for name in columns if "_std_" in name] == ["psnr_std_avg"]
    assert "within_spread" not in columns
    for suffix in ("md", "tex"):
        text = (tmp_path / f"t.{suffix}").read_text()
        assert "±" not in text
        assert "pm$" not in text
        assert "*" not in text.replace("**", "")


def test_a_difference_within_the_spread_is_marked(tmp_path):
    """PSNR of full 20, 22: spread √2. 0.5 dB below it is within, 1.5 dB below is not."""
    psnrs = {"full": (20.0, 22.0), "no_specular": (19.5, 21.5), "no_sky_depth": (18.5, 20.5)}
    files = [
        write_metrics(tmp_path, "chapel", variant, seed, [psnr])
        for variant, each in psnrs.items()
        for seed, psnr in enumerate(each)
    ]
    table1(files, None, tmp_path / "table1.csv")
    table = read(tmp_path / "table1.csv")
    full, near, far = (table.loc[name] for name in table.index)
    for row in (full, near, far):
        assert row.psnr_std_chapel == pytest.approx(2**0.5, rel=1e-5, abs=0)
        assert row.psnr_exact_std_avg == pytest.approx(2**0.5, rel=1e-5, abs=0)
    assert pd.isna(full.within_spread)
    assert {"psnr_chapel", "psnr_avg", "ssim_exact_avg"} <= set(near.within_spread.split(";"))
    # Training views are alike in all runs, and so are means whose differences are nothing.
    assert {name.split("_")[1] for name in far.within_spread.split(";")} == {"learned"}
    lines = (tmp_path / "table1.md").read_text().splitlines()
    assert [line.split("|")[2].strip() for line in lines[4:7]] == [
        "21.00 ± 1.41",
        "20.50 ± 1.41*",
        "19.50 ± 1.41",
    ]
    assert lines[-1].startswith("± is the sample standard deviation over seeds.")
    assert "20.50 $\\pm$ 1.41$^*$" in (tmp_path / "table1.tex").read_text()


def test_a_variant_of_one_seed_among_others_of_several_has_no_spread(files, tmp_path):
    table1(files[:5] + files[6:7], None, tmp_path / "table1.csv")
    row = read(tmp_path / "table1.csv").loc["r3gw without specular"]
    assert pd.isna(row.psnr_std_chapel)
    assert pd.isna(row.within_spread)
    cell = (tmp_path / "table1.md").read_text().splitlines()[5].split("|")[2]
    assert cell.strip() == "19.00"


def test_rows_are_called_and_ordered_as_what_they_are(tmp_path):
    given = ("own_try", "r3gw_plus", "no_specular", "full", "no_sky_depth")
    files = [write_metrics(tmp_path, "chapel", variant, 0, [20.0]) for variant in given]
    table1(files, None, tmp_path / "table1.csv")
    table = pd.read_csv(tmp_path / "table1.csv")
    assert list(zip(table.method, table.group, strict=True)) == [
        ("r3gw", "measured"),
        ("r3gw without specular", "measured ablation"),
        ("r3gw without sky-depth loss", "measured ablation"),
        ("r3gw_plus", "measured, beyond the paper"),
        ("r3gw, own try", "measured, own settings"),
    ]
    assert list(table.variant) == ["full", "no_specular", "no_sky_depth", "r3gw_plus", "own_try"]


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="needs LaTeX")
def test_latex_compiles(files, tmp_path):
    table1(files, None, tmp_path / "table1.csv")
    document = (
        "\\documentclass{article}\\usepackage{booktabs,graphicx}\\begin{document}"
        "\\resizebox{\\linewidth}{!}{\\input{table1}}\\end{document}"
    )
    (tmp_path / "paper.tex").write_text(document)
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "paper.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:]


def test_published_rows_only_beside_the_papers_scenes(tmp_path, repository):
    published = repository / "config" / "published.csv"
    other = [write_metrics(tmp_path, "chapel", "full", 0, [20.0])]
    table1(other, published, tmp_path / "other.csv")
    assert len(pd.read_csv(tmp_path / "other.csv")) == 1

    real = [
        write_metrics(tmp_path, scene, "full", 0, [20.0], exact=False)
        for scene in ("lk2", "lwp", "st")
    ]
    table1(real, published, tmp_path / "real.csv")
    table = read(tmp_path / "real.csv")
    assert len(table) == 13
    assert table.loc["R3GW"].group == "published GS"
    assert table.loc["R3GW"].psnr_avg == 18.11
    assert table.loc["R3GW without specular"].group == "published Ablation"
    assert table.loc["r3gw"].group == "measured"
    assert pd.isna(table.loc["FEGR"].ssim_avg)
    assert pd.isna(table.loc["R3GW"].iterations)
    latex = (tmp_path / "real.tex").read_text()
    published_panel, measured_panel = latex.split("\\addlinespace")[:2]
    assert "\\emph{published, protocol nerf-osr" in published_panel
    assert "R3GW & " in published_panel
    assert "R3GW &" not in measured_panel


def test_a_scene_without_truth_has_no_exact_column_and_none_in_the_average(tmp_path):
    files = [
        write_metrics(tmp_path, "chapel", "full", 0, [20.0]),
        write_metrics(tmp_path, "lk2", "full", 0, [30.0], exact=False),
    ]
    table1(files, None, tmp_path / "table1.csv")
    row = read(tmp_path / "table1.csv").loc["r3gw"]
    assert "psnr_exact_lk2" not in row.index
    assert (row.psnr_avg, row.psnr_exact_avg) == (25.0, 19.0)


def test_a_variant_that_lacks_a_scene_has_no_average(files, tmp_path):
    table1(files[:6], None, tmp_path / "table1.csv")
    row = read(tmp_path / "table1.csv").loc["r3gw without specular"]
    assert row.psnr_chapel == 20.0
    assert pd.isna(row.psnr_arcade)
    assert pd.isna(row.psnr_avg)


def test_ablations_have_spread_per_scene(files, tmp_path):
    ablations(files, tmp_path / "ablations.csv")
    row = read(tmp_path / "ablations.csv").loc["r3gw"]
    assert (row.psnr_chapel, row.psnr_avg, row.n_seeds) == (23.0, 21.0, 2)
    assert row.psnr_std_chapel == pytest.approx(2**0.5, rel=1e-5, abs=0)
    assert (row.albedo_psnr_avg, row.light_error_avg) == (20.5, 0.25)
    assert row.oracle_psnr_exact_avg == 26.0


def test_one_row_per_run(files, tmp_path):
    runs_table(files, tmp_path / "runs.csv")
    decomposition(files, tmp_path / "decomposition.csv")
    runs = pd.read_csv(tmp_path / "runs.csv")
    assert len(runs) == 8
    assert list(runs.columns[:4]) == ["scene", "variant", "seed", "psnr"]
    assert list(runs.psnr[:4]) == [22.0, 24.0, 18.0, 20.0]
    assert set(runs.settings_digest) >= {"digestfull0", "digestno_specular1"}
    parts = pd.read_csv(tmp_path / "decomposition.csv")
    assert list(parts.albedo_psnr[:2]) == [20.0, 21.0]
    assert "psnr" not in parts.columns


def test_cost_of_every_run(files, tmp_path):
    cost(files, tmp_path / "cost.csv")
    row = pd.read_csv(tmp_path / "cost.csv").loc[1]
    assert (row.scene, row.variant, row.seed) == ("chapel", "full", 1)
    assert row.training_minutes == pytest.approx(11.0 / 60, rel=1e-5, abs=0)
    assert (row.training_peak_rss_mb, row.num_gaussians) == (501.0, 1201)
    assert (row.renders_per_second, row.render_megapixels) == (41.0, 0.0432)


def test_one_row_per_image_and_protocol(files, tmp_path):
    images_table(files, tmp_path / "images.csv")
    images = pd.read_csv(tmp_path / "images.csv")
    assert len(images) == 8 * (2 + 2 + 2 + 1)
    chosen = images[(images.scene == "arcade") & (images.variant == "full") & (images.seed == 1)]
    by_image = chosen.set_index(["protocol", "view"])
    assert by_image.loc[("exact", "v1"), "psnr"] == 21.0
    assert by_image.loc[("exact", "v1"), "oracle_psnr"] == 27.0
    assert set(chosen.settings_digest) == {"digestfull1"}


def test_photos_without_test_views_still_make_a_table(tmp_path):
    path = write_metrics(tmp_path, "sacre", "full", 0, [])
    table1([path], None, tmp_path / "table1.csv")
    row = read(tmp_path / "table1.csv").loc["r3gw"]
    assert row.psnr_learned_sacre == 30.0
    assert "psnr_sacre" not in row.index


def test_bad_files_are_named(files, tmp_path):
    with pytest.raises(InputError, match="at least one"):
        table1([], None, tmp_path / "t.csv")
    with pytest.raises(InputError, match=r"gone\.json: no such file"):
        table1([tmp_path / "gone.json"], None, tmp_path / "t.csv")
    with pytest.raises(InputError, match="scene chapel, variant full, seed 0"):
        table1([files[0], files[0]], None, tmp_path / "t.csv")
    (files[0].with_name("cost.json")).unlink()
    with pytest.raises(InputError, match=r"cost\.json: no such file; train and evaluate the run"):
        cost(files[:1], tmp_path / "cost.csv")
    (tmp_path / "old.json").write_text("{}")
    (tmp_path / "cost.json").write_text("{}")
    with pytest.raises(InputError, match=r"old\.json: not a metrics file"):
        table1([tmp_path / "old.json"], None, tmp_path / "t.csv")
