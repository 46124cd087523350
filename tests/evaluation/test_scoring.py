"""r3gw.evaluation.scoring on two pictures worked out on paper, and on our own renders."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from r3gw.cli.group import cli
from r3gw.cli.score import score as _registered  # noqa: F401
from r3gw.evaluation.scoring import mean_scores, pooled_scores, score_folders
from r3gw.evaluation.stage import evaluate_run
from r3gw.files import InputError
from r3gw.imaging.files import write_image


@pytest.fixture
def folders(tmp_path):
    """Two pictures of 20x20.

    a: 0.6 against 0.4; the mask's left half is white, which erosion by 5x5 leaves 8 columns of:
    160 of 400 pixels. b: 0.6 against 0.2, the whole picture counts.
    """
    half = np.zeros((20, 20), np.bool_)
    half[:, :10] = True
    for name, picture, photo, mask in (("a", 153, 102, half), ("b", 153, 51, half | True)):
        for kind, value in (("renders", picture), ("truth", photo)):
            write_image(tmp_path / kind / f"{name}.png", np.full((20, 20, 3), value, np.uint8))
        write_image(tmp_path / "masks" / f"{name}.png", mask)
    return tmp_path


def close(value: float):
    """Equal to the digits worked out on paper."""
    return pytest.approx(value, rel=1e-5, abs=0)


def test_each_picture_on_paper(folders):
    a, b = score_folders(folders / "renders", folders / "truth", folders / "masks")
    assert (a.name, a.num_pixels, b.name, b.num_pixels) == ("a", 160, "b", 400)
    # a: error 0.2; -10 log10(0.04 + 1e-6). b: error 0.4; -10 log10(0.16 + 1e-6).
    assert (a.masked.mse, a.masked.mae, a.masked.psnr) == (close(0.04), close(0.2), close(13.97929))
    assert (b.masked.mse, b.masked.mae, b.masked.psnr) == (close(0.16), close(0.4), close(7.958773))
    # Constant pictures: (2 x y + 1e-4) / (x^2 + y^2 + 1e-4).
    assert a.masked.ssim == close(0.4801 / 0.5201)
    assert b.masked.ssim == close(0.2401 / 0.4001)


def test_zero_filled_counts_the_black_outside(folders):
    a, b = score_folders(folders / "renders", folders / "truth", folders / "masks")
    # 160 of 400 pixels have error 0.2, the others none: MSE 0.016, MAE 0.08.
    assert (a.zero_filled.mse, a.zero_filled.mae) == (close(0.016), close(0.08))
    assert a.zero_filled.psnr == close(17.95853)
    assert b.zero_filled == b.masked


def test_mean_is_over_pictures_pooled_over_pixels(folders):
    scored = score_folders(folders / "renders", folders / "truth", folders / "masks")
    mean, pooled = mean_scores([each.masked for each in scored]), pooled_scores(scored)
    assert (mean.mse, mean.psnr) == (close(0.1), close(10.969032))
    # (160 * 0.04 + 400 * 0.16) / 560 = 70.4 / 560
    assert (pooled.mse, pooled.psnr) == (close(0.1257143), close(9.006128))
    assert pooled.mae == close((160 * 0.2 + 400 * 0.4) / 560)


def test_without_masks_whole_pictures_count(folders):
    a, _ = score_folders(folders / "renders", folders / "truth", None)
    assert a.num_pixels == 400
    assert a.zero_filled == a.masked


def test_our_own_renders_get_the_figures_of_the_table(tiny, tmp_path):
    evaluate_run(tiny.folder, tiny.masks, tiny.model_path, tmp_path, num_threads=1)
    (scored,) = score_folders(
        tmp_path / "renders" / "exact",
        tiny.folder / "images",
        tiny.folder / "given" / "eval",
    )
    record = json.loads((tmp_path / "images" / "exact" / "b_exact.json").read_text())
    # The file's picture is rounded to 8 bits: errors of 1/510 at most.
    assert scored.masked.mae == pytest.approx(record["mae"], rel=0, abs=1 / 510)
    assert scored.masked.ssim == pytest.approx(record["ssim"], rel=0, abs=2e-3)


def test_command_prints_labelled_variants_and_writes_rows(folders):
    out = folders / "scores.csv"
    arguments = ["score", "--output", str(out)]
    for name in ("renders", "truth", "masks"):
        arguments += [f"--{name}", str(folders / name)]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 0, result.output
    lines = {
        line.split("|")[1].split("(")[0].strip(): line
        for line in result.output.splitlines()
        if line.startswith("|")
    }
    assert "10.9690" in lines["masked"]
    assert "12.9587" in lines["zero-filled"]  # (17.95853 + 7.95877) / 2
    assert "9.0061" in lines["pooled"]
    assert "not comparable" in lines["zero-filled"]
    assert "not comparable" in lines["pooled"]
    rows = out.read_text().splitlines()
    assert rows[0].startswith("picture,psnr,ssim,mse,mae,psnr_zero_filled")
    assert rows[1].startswith("a,13.9793,")


def test_wrong_folders_are_named(folders):
    renders, truth, masks = (folders / name for name in ("renders", "truth", "masks"))
    with pytest.raises(InputError, match="nowhere: no such folder"):
        score_folders(folders / "nowhere", truth, masks)
    (folders / "empty").mkdir()
    with pytest.raises(InputError, match="empty: holds no picture"):
        score_folders(folders / "empty", truth, masks)
    write_image(renders / "b.jpg", np.zeros((20, 20, 3), np.uint8))
    with pytest.raises(InputError, match=r"holds both b\.jpg and b\.png"):
        score_folders(renders, truth, masks)
    (renders / "b.jpg").unlink()
    (masks / "b.png").unlink()
    with pytest.raises(InputError, match="masks: holds no mask named b, as the renders need"):
        score_folders(renders, truth, masks)
    write_image(truth / "a.png", np.zeros((20, 24, 3), np.uint8))
    with pytest.raises(InputError, match=r"20x20 px, but .*a\.png is 24x20 px"):
        score_folders(renders, truth, None)
