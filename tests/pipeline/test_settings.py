"""Configuration: everything shipped is valid; every mistake is one clear sentence."""

import copy

import pytest

from r3gw.files import InputError
from r3gw.files.strict import read_yaml
from r3gw.pipeline.config import load_config, run_settings
from r3gw.pipeline.scene_entry import parse_entry
from r3gw.training.settings import load_train_settings


@pytest.fixture
def values(repository):
    return copy.deepcopy(read_yaml(repository / "config/config.yaml"))


def test_shipped_configuration_resolves_for_every_variant(values, files):
    config = load_config(values)
    for variant in read_yaml(files["variants_file"]):
        settings = run_settings(config, variant, 3, **files)
        assert settings.seed == 3
        assert settings.iterations == values["train"]["iterations"]


def test_variants_change_what_they_say(values, files):
    config = load_config(values)
    full = run_settings(config, "full", 0, **files)
    diffuse = run_settings(config, "no_specular", 0, **files)
    assert (full.model.specular, full.model.light_degree) == (True, 4)
    assert (diffuse.model.specular, diffuse.model.light_degree) == (False, 2)
    expected = full.model.model_copy(update={"specular": False, "light_degree": 2})
    assert diffuse == full.model_copy(update={"model": expected})


def test_constant_threshold_is_the_first_of_the_run(values, files):
    config = load_config(values)
    full = run_settings(config, "full", 0, **files)
    constant = run_settings(config, "constant_threshold", 0, **files)
    assert full.density.threshold_last is not None
    assert constant.density == full.density.model_copy(update={"threshold_last": None})


def test_misspelt_key_names_itself_and_the_likely_one(values):
    values["varients"] = values.pop("variants")
    with pytest.raises(InputError, match=r"unknown key 'varients'; did you mean 'variants'\?"):
        load_config(values, "config.yaml")


def test_misspelt_train_key_fails_too(values, files):
    values["train"]["iteration"] = 5
    with pytest.raises(InputError, match="unknown key 'iteration'; did you mean 'iterations'"):
        run_settings(load_config(values), "full", 0, **files)


def test_wrong_value_is_named(values, files):
    values["train"]["iterations"] = -4
    with pytest.raises(InputError, match=r"'iterations' has the value -4.*greater than"):
        run_settings(load_config(values), "full", 0, **files)


def test_unknown_variant_lists_the_known(values, files):
    with pytest.raises(InputError, match="no variant named 'fuller'; there are: full"):
        run_settings(load_config(values), "fuller", 0, **files)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"format": "nerf", "path": "x"}, "scene 'a': key 'format' has the value 'nerf'"),
        ({"path": "x"}, "scene 'a': key 'format' is missing"),
        ({"format": "photos"}, "scene 'a': key 'path' is missing"),
        ({"format": "photos", "path": "x", "extend": 1}, "unknown key 'extend'; did you mean 'ext"),
        ({"format": "photos", "path": "x", "sky_mask": "none"}, "did you mean 'sky_masks'?"),
        ({"format": "photos", "path": "x", "network": {"model": "x"}}, "'network.sky' is missing"),
    ],
)
def test_a_wrong_scene_entry_is_one_sentence_in_the_files_own_keys(entry, said):
    with pytest.raises(InputError) as error:
        parse_entry(entry, "scene 'a'")
    assert said in str(error.value)


def test_an_entry_keeps_its_keys_and_its_formats_defaults():
    keys = {"format": "synthetic", "building": "chapel", "samples": 3, "valid_masks": "all"}
    entry = parse_entry(keys, "scene 'a'")
    assert (entry.masks.sky_masks, entry.masks.valid_masks) == ("given", "all")
    assert entry.model_dump(mode="json").items() >= keys.items()
    assert parse_entry(entry.model_dump(mode="json"), "again") == entry
    photos = parse_entry({"format": "photos", "path": "x"}, "scene 'b'")
    assert photos.masks.sky_masks == "given-or-labels-or-classical"


def test_scientific_numbers_are_numbers(values, files):
    """PyYAML reads 1e-4 (no dot) as text; the settings still come out as numbers."""
    values["train"]["rates"] = {"albedo": "2e-3"}
    assert run_settings(load_config(values), "full", 0, **files).rates.albedo == 0.002


def test_settings_file_round_trip(tmp_path, values, files):
    settings = run_settings(load_config(values), "full", 0, **files)
    path = tmp_path / "settings.json"
    path.write_text(settings.model_dump_json(indent=2))
    assert load_train_settings(path) == settings


def test_missing_and_broken_files(tmp_path):
    with pytest.raises(InputError, match="no such settings file"):
        load_train_settings(tmp_path / "none.json")
    broken = tmp_path / "broken.yaml"
    broken.write_text("a: [1")
    with pytest.raises(InputError, match="not readable as YAML"):
        read_yaml(broken)
