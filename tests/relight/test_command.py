"""``python -m r3gw relight`` and ``export``: options reach the pictures, mistakes are one line."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from r3gw.__main__ import cli
from r3gw.files import InputError
from r3gw.imaging.files import read_rgb


def run(tiny, command: str, *options: str, catch: bool = True):
    shared = ("--model", str(tiny.model_path), "--scene", str(tiny.folder))
    return CliRunner().invoke(cli, [command, *shared, *options], catch_exceptions=catch)


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
    ("command", "options", "target", "said"),
    [
        ("relight", ("--view", "a_0"), "a/b.png", "a/b.png"),
        ("relight", ("--view", "a_0", "--frames", "3"), "%02d.png", "00.png to 02.png"),
        (
            "relight",
            ("--view", "a_0", "--frames", "3", "--fps", "2"),
            "day.mp4",
            "day.mp4 (3 frames, 1.5 s)",
        ),
        (
            "export",
            (),
            "out",
            "out: viewers of Gaussian splats open baked.ply, others baked.glb",
        ),
        ("export", (), "p.html", "p.html: open it in a browser; it needs no network"),
    ],
)
def test_what_was_written_is_told(
    tiny, tmp_path, caplog, monkeypatch, command, options, target, said
):
    """In one line, with the path as it was given."""
    monkeypatch.chdir(tmp_path)
    caplog.set_level("INFO", "r3gw")
    option = "--output" if command == "relight" else "--target"
    assert run(tiny, command, *options, "--light-of", "a_0", option, target).exit_code == 0
    assert caplog.messages == [f"wrote {said}"]
    assert {path.name for path in tmp_path.rglob("*")} >= {Path(target).name} - {"%02d.png"}


@pytest.mark.parametrize("command", ["relight", "export"])
def test_a_missing_map_is_told_before_the_model_is_read(tiny, tmp_path, monkeypatch, command):
    for module in ("film", "trained"):
        monkeypatch.setattr(f"r3gw.relight.{module}.load_relightable", None)
    given = ("--view", "a_0", "--output") if command == "relight" else ("--target",)
    options = ("--env-map", "sunset.hdr", *given, str(tmp_path / "o.png"))
    with pytest.raises(InputError, match=r"^sunset\.hdr: no such environment map; check the name"):
        run(tiny, command, *options, catch=False)


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
