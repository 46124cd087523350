"""The settings of config/train.yaml with changes on top, as tests need them."""

from pathlib import Path
from typing import Any

from r3gw.files.strict import read_yaml
from r3gw.training.settings import TrainSettings

TRAIN_FILE = Path(__file__).parents[2] / "config" / "train.yaml"


def train_settings(**changes: Any) -> TrainSettings:
    """The paper's settings with changes; a mapping changes some keys of a group, the rest stays.

    ``train_settings(seed=5, rates={"short_run_boost": 5.0})``
    """
    values = read_yaml(TRAIN_FILE)
    for key, value in changes.items():
        values[key] = {**values[key], **value} if isinstance(value, dict) else value
    return TrainSettings.model_validate(values)
