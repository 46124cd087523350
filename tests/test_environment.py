"""environment.yml (conda) pins what pyproject.toml pins."""

import tomllib

import yaml


def test_conda_pins_equal_pip_pins(repository):
    project = tomllib.loads((repository / "pyproject.toml").read_text())
    wanted = {*project["project"]["dependencies"], *project["build-system"]["requires"]}
    conda = yaml.safe_load((repository / "environment.yml").read_text())["dependencies"]
    pip = next(entry["pip"] for entry in conda if isinstance(entry, dict))
    assert set(pip) == wanted


def test_every_pin_is_exact(repository):
    project = tomllib.loads((repository / "pyproject.toml").read_text())
    extras = project["project"]["optional-dependencies"].values()
    pins = [*project["project"]["dependencies"], *(pin for extra in extras for pin in extra)]
    assert all("==" in pin for pin in pins)
    assert "torch==2.13.0" in pins
