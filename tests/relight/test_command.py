"""``python -m r3gw relight`` and ``export``: options reach the pictures, mistakes are one line."""

import numpy as np
import pytest
from click.testing import CliRunner

from r3gw.__main__ import cli
from r3gw.imaging.files import read_rgb


def run(tiny, command: str, *options: str):
    shared = ("--model", str(tiny.model_path), "--scene", str(tiny.folder))
    return CliRunner().invoke(cli, [command, *shared, *options])


def test_a_moving_sun_from_the_command_line(tiny, tmp_path):
    done = run(
        tiny, "relight", "--view", "a_0", "--sun", "10:70", "180", "--sky", "white", "--frames",
        "2", "--orbit-deg", "-5:5", "--width", "24", "--output", str(tmp_path / "%d.png"),
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    dawn, noon = (read_rgb(tmp_path / f"{i}.png").astype(int) for i in (0, 1))
    assert dawn.shape == (16, 24, 3)
    assert np.abs(dawn - noon).mean() > 5


def test_exported_from_the_command_line_and_relit(tiny, tmp_path):
    done = run(tiny, "export", "--light-of", "a_0", "--target", str(tmp_path))
    assert done.exit_code == 0, done.output
    for name, model in (("ply", tmp_path / "relightable.ply"), ("pt", tiny.model_path)):
        options = ["--model", str(model), "--scene", str(tiny.folder), "--view", "a_1"]
        options += ["--light-of", "a_1", "--tone", "filmic", "--output", str(tmp_path / name)]
        options[-1] += ".png"
        assert CliRunner().invoke(cli, ["relight", *options]).exit_code == 0
    assert (read_rgb(tmp_path / "ply.png") == read_rgb(tmp_path / "pt.png")).all()


def test_a_view_that_is_mostly_guessed_is_told_and_darkened(tiny, tmp_path):
    """From behind the wall, whose photos all stand before it."""
    view = ("--view", "a_0", "--light-of", "a_0")
    seen = run(tiny, "relight", *view, "--output", str(tmp_path / "seen.png"))
    assert "guessed" not in seen.output
    pictures = []
    for choice in ("shown", "dimmed"):
        out = tmp_path / f"{choice}.png"
        around = ("--orbit-deg", "180", "--guessed", choice)
        done = run(tiny, "relight", *view, *around, "--output", str(out))
        assert done.exit_code == 0
        assert done.output == (
            "0 % of the surfaces in view were seen by 2 photos from within 30 degrees; the rest "
            "is guessed (--guessed dimmed)\n"
        )
        pictures.append(read_rgb(out).astype(int))
    assert pictures[1].mean() < 0.8 * pictures[0].mean()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--sun", "high", "90"), "neither a number nor FROM:TO"),
        (("--sun", "30"), "neither a number nor FROM:TO"),
        (("--light-of", "a_0", "--exposure", "-1"), "neither a factor above 0 nor 'auto'"),
        (("--light-of", "a_0", "--tone", "vivid"), "standard"),
    ],
)
def test_mistyped_options_are_told(tiny, tmp_path, options, said):
    out = tmp_path / "o.png"
    done = run(tiny, "relight", "--view", "a_0", *options, "--output", str(out))
    assert done.exit_code == 2
    assert said in done.output
    assert not out.exists()


def test_help_has_sections():
    shown = CliRunner().invoke(cli, ["relight", "--help"]).output
    positions = [shown.index(f"\n{name}") for name in ("Scene:", "Camera:", "Light (", "Output:")]
    assert positions == sorted(positions)
    assert "FROM:TO" in shown
