"""config/config.yaml: which scenes, variants and seeds a workflow run covers."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from r3gw.files import InputError
from r3gw.files.strict import Strict, read_yaml, validated
from r3gw.pipeline.scene_entry import SceneEntry
from r3gw.pipeline.study import StudySettings, VariantName
from r3gw.training.settings import TrainSettings

OF_FIRST_POINTS = ("sky", "stereo")  # Groups of settings that all runs of a scene share.

SceneName = Annotated[str, Field(pattern="^[A-Za-z0-9][A-Za-z0-9_-]*$")]


class AblationSettings(Strict):
    """What ``snakemake ablations`` covers."""

    variants: list[VariantName] = Field(min_length=1)
    seeds: list[int] = Field(min_length=1)


class Config(Strict):
    """The whole of config.yaml.

    ``train`` holds changes to config/train.yaml that every variant of this run shares; ``study``
    is for ``snakemake study`` alone. No result depends on ``checkpoint_seconds``, which says how
    often a training saves its state.
    """

    scenes: dict[SceneName, SceneEntry] = Field(min_length=1)
    variants: list[VariantName] = Field(min_length=1)
    seeds: list[int] = Field(min_length=1)
    ablations: AblationSettings
    train: dict[str, Any] = Field(default_factory=dict)
    study: StudySettings | None = None
    checkpoint_seconds: float = Field(default=300.0, gt=0)

    @property
    def all_variants(self) -> list[str]:
        """Every variant that a target of the workflow may train, sorted."""
        studied = [] if self.study is None else self.study.variants
        return sorted({*self.variants, *self.ablations.variants, *studied})

    @property
    def all_seeds(self) -> list[int]:
        """Every seed that a target of the workflow may train, sorted."""
        studied = [] if self.study is None else self.study.seeds
        return sorted({*self.seeds, *self.ablations.seeds, *studied})


def load_config(values: Mapping[str, Any], source: str = "config") -> Config:
    """Validate the contents of config.yaml.

    Raises:
        InputError: On the first unknown key, missing key or wrong value.
    """
    return validated(Config, values, source)


def run_settings(
    config: Config, variant: str, seed: int, *, train_file: Path, variants_file: Path
) -> TrainSettings:
    """Resolve one run: train.yaml, then the config's ``train``, then the variant, then the seed.

    A change of the config's study is a variant too: it comes on top of the study's baseline.

    Raises:
        InputError: If the variant is unknown or any resolved key is unknown or out of range.
    """
    values = read_yaml(train_file)
    for changes in (config.train, *_variant(config, variant, variants_file), {"seed": seed}):
        values = _merged(values, changes)
    return validated(TrainSettings, values, f"settings of variant '{variant}'")


def _variant(config: Config, name: str, variants_file: Path) -> list[Mapping[str, Any]]:
    """What a variant changes, in the order in which it does."""
    shared = read_yaml(variants_file)
    own = {} if config.study is None else config.study.changes
    if taken := [each for each in own if each in shared]:
        raise InputError(
            f"study: the change '{taken[0]}' has the name of a variant in {variants_file}; "
            "call it something else"
        )
    if config.study is None or name not in own:
        return [_changes_of(shared, name, str(variants_file))]
    baseline = _changes_of(shared, config.study.baseline, str(variants_file))
    return [baseline, _changes_of(own, name, "study")]


def _changes_of(variants: Mapping[str, Any], name: str, source: str) -> Mapping[str, Any]:
    """What one variant changes; an InputError if there is none, or if it may not change that."""
    if name not in variants:
        raise InputError(f"{source}: no variant named '{name}'; there are: {', '.join(variants)}")
    changes: Mapping[str, Any] = variants[name] or {}
    for group in OF_FIRST_POINTS:
        if group in changes:
            raise InputError(
                f"{source}: variant '{name}' changes '{group}', but all runs of a scene share "
                f"their initial points; change '{group}' under 'train' in config.yaml"
            )
    return changes


def _merged(base: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``base`` with ``changes`` on top, group by group."""
    result = dict(base)
    for key, value in changes.items():
        old = result.get(key)
        result[key] = _merged(old, value) if isinstance(old, dict) else value
    return result
