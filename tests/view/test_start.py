"""The light in which an exported page opens."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from r3gw.__main__ import cli
from r3gw.files import InputError
from r3gw.model.model_file import save_model
from r3gw.relight.lights import LightOptions, MapSource, PhotoSource, SunSource
from r3gw.relight.sweep import Sweep
from r3gw.view.start import start_of


def still(value: float) -> Sweep:
    """A number that does not move."""
    return Sweep((value,))


def test_a_blend_of_photos():
    source = PhotoSource(("a", "b"), still(0.25))
    assert start_of(LightOptions(source, still(270.0), exposure=2.0, sky="white"), "filmic") == {
        "light": "learned",
        "photo": "a",
        "photo2": "b",
        "blend": 0.25,
        "yaw": -90.0,
        "tone": "filmic",
        "sky": "white",
        "auto": False,
        "stops": 1.0,
    }


def test_the_sun_before_a_photos_sky_with_the_exposure_of_the_photos():
    source = SunSource(still(30.0), still(-20.0), 5.0)
    assert start_of(LightOptions(source, sky="learned:c"), "standard") == {
        "light": "sun",
        "elevation": 30.0,
        "azimuth": 340.0,
        "turbidity": 5.0,
        "yaw": 0.0,
        "tone": "standard",
        "sky": "learned",
        "photo": "c",
        "auto": True,
    }


def test_maps_are_left_to_the_reader():
    with pytest.raises(InputError, match="--light-of or --sun"):
        start_of(LightOptions(MapSource(Path("m.hdr"))), "standard")


def test_export_writes_a_page_where_the_target_is_one(tmp_path, model, scene_folder):
    save_model(model, tmp_path / "model.safetensors")
    target = tmp_path / "out.html"
    arguments = ["export", "--model", str(tmp_path / "model.safetensors"), "--light-of", "b"]
    arguments += ["--scene", str(scene_folder), "--target", str(target)]
    outcome = CliRunner().invoke(cli, arguments, catch_exceptions=False)
    assert outcome.exit_code == 0
    assert target.read_text().startswith("<!doctype html>")
    assert [path.name for path in tmp_path.iterdir() if path.suffix != ".safetensors"] == [
        "out.html"
    ]
