"""JSON schemas of the configuration files, for editors and catalogues, written from the settings.

``python -m r3gw.pipeline.schema workflow/schemas`` writes them (`make schemas`). The workflow
itself checks a configuration by `r3gw.pipeline.config`, which says more in its errors.
"""

import sys
from pathlib import Path
from typing import Any

import yaml

from r3gw.files.atomic import write_bytes
from r3gw.pipeline.config import Config
from r3gw.training.settings import TrainSettings

Schema = dict[str, Any]

_DIALECT = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
_TITLES = {
    "config": "What a run of the workflow covers (config/README.md)",
    "train": "Every hyperparameter, once (config/train.yaml)",
    "variants": "What each variant changes in config/train.yaml",
}


def config_schema() -> Schema:
    """Schema of a configuration of a whole run, such as config/config.yaml."""
    schema = Config.model_json_schema()
    changes, definitions = _changes()
    definitions |= schema["$defs"]
    definitions["SceneEntry"] = _scene_entry(definitions)
    schema["$defs"] = dict(sorted(definitions.items()))
    schema["properties"]["train"] |= changes
    named = definitions["StudySettings"]["properties"]["changes"]["patternProperties"]
    named |= dict.fromkeys(named, changes)
    return _finished("config", schema)


def train_schema() -> Schema:
    """Schema of config/train.yaml."""
    schema = TrainSettings.model_json_schema()
    return _finished("train", schema)


def variants_schema() -> Schema:
    """Schema of config/variants.yaml: changes by the name of a variant, or nothing."""
    changes, definitions = _changes()
    values = {"anyOf": [changes, {"type": "null"}]}
    schema = {"$defs": definitions, "type": "object", "additionalProperties": values}
    return _finished("variants", schema)


def _changes() -> tuple[Schema, Schema]:
    """Any part of the settings of a training: a reference to it, and the definitions that it needs.

    Groups lose their lists of required keys, since a change names only what it changes.
    """
    whole = TrainSettings.model_json_schema()
    definitions = {f"{name}Changes": each for name, each in whole.pop("$defs").items()}
    definitions["TrainChanges"] = whole
    for each in definitions.values():
        each.pop("required", None)
    renamed: Schema = _renamed(definitions)
    return {"$ref": "#/$defs/TrainChanges"}, renamed


def _renamed(value: Any) -> Any:
    """A schema whose references go to the definitions of changes."""
    if isinstance(value, dict):
        return {
            key: f"{each}Changes" if key == "$ref" else _renamed(each)
            for key, each in value.items()
        }
    return [_renamed(each) for each in value] if isinstance(value, list) else value


def _scene_entry(definitions: Schema) -> Schema:
    """One mapping of a source's keys and those about masks, as `SceneEntry` reads it."""
    masks = definitions.pop("MaskSources")["properties"]
    source = definitions.pop("SceneEntry")["properties"]["source"]
    for choice in source["oneOf"]:
        definitions[choice["$ref"].rpartition("/")[2]]["properties"] |= masks
    return {"oneOf": source["oneOf"]}


def _finished(kind: str, schema: Schema) -> Schema:
    return _DIALECT | {"title": _TITLES[kind]} | {k: v for k, v in schema.items() if k != "title"}


def schemas() -> dict[str, str]:
    """The text of every schema, by the name of its file."""
    built = {"config": config_schema(), "train": train_schema(), "variants": variants_schema()}
    head = "# Written from the settings' types by `make schemas`.\n"
    return {
        f"{name}.schema.yaml": head + yaml.safe_dump(schema, sort_keys=False, width=100)
        for name, schema in built.items()
    }


def main(folder: Path) -> None:
    """Write all schemas into a folder."""
    for name, text in schemas().items():
        write_bytes(folder / name, text.encode())


if __name__ == "__main__":
    main(Path(sys.argv[1]))
