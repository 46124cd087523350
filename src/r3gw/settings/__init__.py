"""What a user may set, validated: config.yaml, train.yaml, variants.yaml. Unknown keys fail."""

from r3gw.settings.config import (
    ColmapScene,
    Config,
    NerfOsrOriginalScene,
    NerfOsrScene,
    NerfstudioScene,
    PhotosScene,
    SceneSettings,
    SyntheticScene,
    load_config,
    run_settings,
)
from r3gw.settings.masks import LabelClasses, MaskSources, NetworkSettings
from r3gw.settings.study import StudySettings
from r3gw.settings.train import TrainSettings, load_train_settings

__all__ = [
    "ColmapScene",
    "Config",
    "LabelClasses",
    "MaskSources",
    "NerfOsrOriginalScene",
    "NerfOsrScene",
    "NerfstudioScene",
    "NetworkSettings",
    "PhotosScene",
    "SceneSettings",
    "StudySettings",
    "SyntheticScene",
    "TrainSettings",
    "load_config",
    "load_train_settings",
    "run_settings",
]
