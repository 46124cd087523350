"""Studies: a change is one more variant, on top of the baseline; every mistake is one sentence."""

import copy

import pytest

from r3gw.files import InputError
from r3gw.files.strict import read_yaml
from r3gw.pipeline.config import load_config, run_settings


@pytest.fixture
def values(repository):
    values = copy.deepcopy(read_yaml(repository / "config/config.yaml"))
    values["study"] = {
        "baseline": "no_specular",
        "seeds": [4],
        "changes": {"dim": {"init": {"light_radiance": 0.5}}},
    }
    return values


def test_a_change_comes_on_top_of_the_baseline(values, files):
    config = load_config(values)
    baseline = run_settings(config, "no_specular", 4, **files)
    dim = run_settings(config, "dim", 4, **files)
    assert not baseline.model.specular
    assert baseline.init.light_radiance != 0.5
    expected = baseline.init.model_copy(update={"light_radiance": 0.5})
    assert dim == baseline.model_copy(update={"init": expected})


def test_a_change_wins_over_the_baseline(values, files):
    values["study"]["changes"]["dim"] = {"model": {"light_degree": 4}}
    settings = run_settings(load_config(values), "dim", 4, **files)
    assert (settings.model.specular, settings.model.light_degree) == (False, 4)


def test_the_workflow_may_train_what_any_target_names(values):
    config = load_config(values)
    named = {*values["variants"], *values["ablations"]["variants"]}
    assert config.all_variants == sorted({*named, "no_specular", "dim"})
    assert config.all_seeds == [0, 1, 2, 4]
    assert "dim" not in load_config({**values, "study": None}).all_variants


@pytest.mark.parametrize(
    ("study", "said"),
    [
        (
            {"changes": {"full": {"iterations": 5}}},
            "study: the change 'full' has the name of a var",
        ),
        ({"baseline": "dim"}, "no variant named 'dim'; there are: full"),
        ({"changes": {"dim": {"sky": {"min_count": 5}}}}, "study: variant 'dim' changes 'sky'"),
        ({"changes": {"dim": {"iteration": 5}}}, "variant 'dim': unknown key 'iteration'; did"),
        ({"changes": {"dim": {"iterations": -5}}}, "'iterations' has the value -5.*greater than"),
        ({"changes": {"dim": {}}}, "'study.changes.dim' has the value {}"),
        ({"changes": {"dim": 3}}, "'study.changes.dim' has the value 3.*dictionary"),
        ({"changes": {"a/b": {"iterations": 5}}}, "'a/b'.*pattern"),
        ({"changes": {}}, "'study.changes' has the value {}"),
        ({"seeds": []}, r"'study.seeds' has the value \[\]"),
        ({"seed": [0]}, "unknown key 'study.seed'; did you mean 'seeds'"),
    ],
)
def test_mistakes_are_named(values, files, study, said):
    values["study"] |= study
    with pytest.raises(InputError, match=said):
        run_settings(load_config(values), "dim", 0, **files)
