"""Three lists of libraries agree: ranges in pyproject.toml, exact versions for pip and conda."""

import re
import tomllib

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from r3gw.files.extras import EXTRAS

MODULES = {"imageio_ffmpeg": "imageio-ffmpeg", "mpl_toolkits": "matplotlib"}


@pytest.fixture
def project(repository) -> dict:
    """pyproject.toml."""
    return tomllib.loads((repository / "pyproject.toml").read_text())


@pytest.fixture
def pins(repository) -> dict[str, str]:
    """Versions of constraints.txt by canonical name."""
    lines = (repository / "constraints.txt").read_text().splitlines()
    found = [line.split("==") for line in lines if not line.startswith("#")]
    return {canonicalize_name(name): version for name, version in found}


def wanted(project: dict, *extras: str) -> list[Requirement]:
    """What an installation with extras asks for, and what building takes."""
    optional = project["project"]["optional-dependencies"]
    texts = [*project["project"]["dependencies"], *project["build-system"]["requires"]]
    return [Requirement(text) for text in [*texts, *(t for e in extras for t in optional[e])]]


def test_every_pin_lies_in_its_range(project, pins):
    for requirement in wanted(project, *project["project"]["optional-dependencies"]):
        version = pins[canonicalize_name(requirement.name)]
        assert requirement.specifier.contains(version), (requirement, version)


def test_conda_pins_are_those_of_pip(repository, project, pins):
    conda = yaml.safe_load((repository / "environment.yml").read_text())["dependencies"]
    given = next(entry["pip"] for entry in conda if isinstance(entry, dict))
    names = {canonicalize_name(r.name) for r in wanted(project, "pipeline", "benchmark", "view")}
    found = dict(entry.split("==") for entry in given)
    assert {canonicalize_name(name): version for name, version in found.items()} == {
        name: pins[name] for name in names
    }


def test_torch_is_one_exact_version_for_building(project, pins):
    building = {Requirement(text).name: text for text in project["build-system"]["requires"]}
    assert building["torch"] == f"torch=={pins['torch']}"


def test_the_extras_that_messages_name_install_the_library(project):
    optional = project["project"]["optional-dependencies"]
    for module, extra in EXTRAS.items():
        name = canonicalize_name(MODULES.get(module, module))
        names = {canonicalize_name(re.split(r"[<>=]", text)[0]) for text in optional[extra]}
        assert name in names, f"{module}: r3gw[{extra}] does not install it"


def test_the_command_and_the_types_are_installed(project):
    assert project["project"]["scripts"] == {"r3gw": "r3gw.__main__:main"}
    assert {"py.typed", "*.pyi"} <= {*project["tool"]["setuptools"]["package-data"]["r3gw"]}
