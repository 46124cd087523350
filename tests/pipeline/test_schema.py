"""The schemas of the configuration files are current, and agree with what the workflow accepts."""

import copy

import jsonschema
import pytest
import yaml

from r3gw.files import InputError
from r3gw.pipeline.config import load_config
from r3gw.pipeline.schema import schemas

WHOLE = ("config.yaml", "nerf_osr.yaml", "photos.yaml", "real_size.yaml")


@pytest.fixture(scope="module")
def validators(repository):
    """A validator of another library for every schema in the repository."""
    found = {}
    for path in (repository / "workflow/schemas").iterdir():
        schema = yaml.safe_load(path.read_text())
        jsonschema.Draft202012Validator.check_schema(schema)
        found[path.name.partition(".")[0]] = jsonschema.Draft202012Validator(schema)
    return found


def test_schemas_are_those_of_the_settings(repository):
    folder = repository / "workflow/schemas"
    written = {path.name: path.read_text() for path in folder.iterdir()}
    assert written == schemas(), "run `make schemas`"


@pytest.mark.parametrize("name", [*WHOLE, "../.test/config/config.yaml"])
def test_configurations_of_this_repository_are_valid(repository, validators, name):
    values = yaml.safe_load((repository / "config" / name).read_text())
    validators["config"].validate(values)
    load_config(values)


@pytest.mark.parametrize("name", ["train", "variants"])
def test_settings_of_this_repository_are_valid(repository, validators, name):
    validators[name].validate(yaml.safe_load((repository / f"config/{name}.yaml").read_text()))


def test_studies_of_this_repository_are_valid(repository, validators):
    studies = sorted((repository / "config/studies").glob("*.yaml"))
    assert len(studies) == 4
    base = yaml.safe_load((repository / "config/config.yaml").read_text())
    for path in studies:
        validators["config"].validate(base | yaml.safe_load(path.read_text()))


WRONG = {
    "unknown key": lambda c: c.update(variant=["full"]),
    "unknown key of a scene": lambda c: c["scenes"]["chapel"].update(with_px=3),
    "a key of another format": lambda c: c["scenes"]["chapel"].update(up="given"),
    "unknown format": lambda c: c["scenes"]["chapel"].update(format="obj"),
    "no format": lambda c: c["scenes"]["chapel"].pop("format"),
    "no variants": lambda c: c.update(variants=[]),
    "a group of train that is none": lambda c: c.update(train={"rates": 3}),
    "a rate that is none": lambda c: c.update(train={"rates": {"roughnes": 0.1}}),
    "a rate of 0": lambda c: c.update(train={"rates": {"roughness": 0}}),
}


@pytest.mark.parametrize("mistake", WRONG)
def test_what_is_wrong_is_refused(repository, validators, mistake):
    values = yaml.safe_load((repository / "config/config.yaml").read_text())
    wrong = copy.deepcopy(values)
    WRONG[mistake](wrong)
    assert not validators["config"].is_valid(wrong)
    if "train" not in mistake and "rate" not in mistake:  # those are read with the variants
        with pytest.raises(InputError):
            load_config(wrong)
