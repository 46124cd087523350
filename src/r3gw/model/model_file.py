"""The file of a trained scene, ``model.safetensors``: arrays, and what they are.

It describes itself: the settings of the training ride along as a record that reading does not look
at, so new settings never make an old model unreadable. Models of the file's version 3
(``model.pt``) are read too.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import torch
from pydantic import Field, ValidationError
from torch import Tensor

from r3gw.files import InputError
from r3gw.files.arrays import read_arrays, write_arrays
from r3gw.files.strict import Strict
from r3gw.lighting import sh
from r3gw.model import foreground, sky
from r3gw.model.appearance import Appearance
from r3gw.model.attributes import FOREGROUND, SKY
from r3gw.model.description import ModelDescription, light_rows
from r3gw.model.model import SceneModel
from r3gw.model.rows import OCCLUSION, Rows
from r3gw.model.sky import Sky, SkyDome
from r3gw.model.version_3 import is_version_3, read_version_3

FILE_VERSION = 4
APPEARANCE = "appearance."
SKY_FACTS = {"centre": (3,), "azimuth_rad": (2,), "radius": ()}
WHAT = "model of r3gw"


class ModelRecord(Strict):
    """The plain values of a model file.

    Attributes:
        description: What the model is.
        photos: Names of the training photos.
        sessions: Their sessions.
    """

    description: ModelDescription
    photos: tuple[str, ...] = Field(min_length=1)
    sessions: tuple[str, ...]


def model_tensors(model: SceneModel) -> dict[str, Tensor]:
    """All arrays of a model by the names that a file gives them."""
    parts: Iterable[tuple[str, Mapping[str, Tensor]]] = (
        (foreground.PREFIX, dict(model.foreground.values.items())),
        (sky.PREFIX, dict(model.sky.rows.values.items())),
        (sky.PREFIX, {name: getattr(model.sky, name) for name in SKY_FACTS}),
        (APPEARANCE, model.appearance.state_dict()),
    )
    return {f"{prefix}{name}": value for prefix, part in parts for name, value in part.items()}


def model_record(model: SceneModel) -> ModelRecord:
    """The plain values of a model."""
    return ModelRecord(description=model.description, photos=model.photos, sessions=model.sessions)


def model_record_from(values: Mapping[str, Any], source: str) -> ModelRecord:
    """Invert ``model_record(...).model_dump()``.

    Raises:
        InputError: If a value is missing, unknown or impossible; ``source`` is named.
    """
    try:
        return ModelRecord.model_validate(values)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise InputError(
            f"{source}: damaged, or no {WHAT} ('{key}': {first['msg']}, got {first['input']!r:.40})"
        ) from None


def save_model(model: SceneModel, path: Path, training: Mapping[str, Any] | None = None) -> None:
    """Write the model atomically, with the settings of its training as a record."""
    record = {"version": FILE_VERSION, "model": model_record(model).model_dump(mode="json")}
    write_arrays(path, model_tensors(model), record | {"training": dict(training or {})})


def load_model(path: Path) -> SceneModel:
    """Read a model written by `save_model`, or by r3gw when the file's version was 3.

    Raises:
        InputError: If the file is missing, damaged, no model, or of another version.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such model; train the scene first")
    tensors, values = read_version_3(path) if is_version_3(path) else _read(path)
    model = model_from(tensors, model_record_from(values, str(path)), str(path))
    model.appearance.eval()
    return model


def _read(path: Path) -> tuple[dict[str, Tensor], dict[str, Any]]:
    """Arrays and plain values of a model of today's version."""
    tensors, content = read_arrays(path, WHAT)
    if content.get("version") != FILE_VERSION:
        raise InputError(
            f"{path}: model file version {content.get('version')!r}, but this r3gw reads "
            f"versions 3 and {FILE_VERSION}; train the scene again"
        )
    values = content.get("model")
    if not isinstance(values, dict):
        raise InputError(f"{path}: no {WHAT}: it does not say what the model is")
    return tensors, values


def model_from(tensors: Mapping[str, Tensor], record: ModelRecord, source: str) -> SceneModel:
    """Invert `model_tensors` and `model_record`.

    Raises:
        InputError: If an array is missing, of a wrong shape or not finite; ``source`` is named.
    """
    description, sessions = record.description, record.sessions
    if len(sessions) != len(record.photos):
        raise InputError(f"{source}: {len(record.photos)} photos but {len(sessions)} sessions")
    rows = light_rows(sessions, description.share_session_light)
    light_model = description.light.build(len(sessions), max(rows) + 1)
    appearance = Appearance(rows, description, light_model, torch.Generator())
    shapes = _shapes(tensors, appearance, description)
    for name in sorted(shapes.keys() ^ tensors.keys()):
        has = "lacks" if name in shapes else "has an unknown"
        raise InputError(f"{source}: no {WHAT}: it {has} array '{name}'")
    for name, shape in shapes.items():
        _require(name, tensors[name], shape, source)
    appearance.load_state_dict(_part(tensors, APPEARANCE))
    return SceneModel(
        description,
        Rows(foreground.PREFIX, _part(tensors, foreground.PREFIX)),
        _sky(_part(tensors, sky.PREFIX)),
        appearance,
        record.photos,
        sessions,
    )


def _shapes(
    tensors: Mapping[str, Tensor], appearance: Appearance, description: ModelDescription
) -> dict[str, tuple[int, ...]]:
    """Names and shapes of all arrays that a model has; the number of Gaussians is the file's."""
    shapes = {f"{APPEARANCE}{k}": tuple(v.shape) for k, v in appearance.state_dict().items()}
    shapes |= {f"{sky.PREFIX}{name}": shape for name, shape in SKY_FACTS.items()}
    for prefix, attributes in ((foreground.PREFIX, FOREGROUND), (sky.PREFIX, SKY)):
        first = tensors.get(f"{prefix}{attributes[0].name}")
        count = 0 if first is None or first.ndim == 0 else len(first)
        shapes |= {f"{prefix}{a.name}": (count, *a.shape) for a in attributes}
        if f"{prefix}{OCCLUSION}" in tensors:
            coefficients = sh.num_coefficients(description.light_degree)
            shapes[f"{prefix}{OCCLUSION}"] = (count, coefficients)
    return shapes


def _require(name: str, tensor: Tensor, shape: tuple[int, ...], source: str) -> None:
    """Refuse an array that is not finite float32 of a shape."""
    if tuple(tensor.shape) != shape or tensor.dtype != torch.float32:
        raise InputError(
            f"{source}: no {WHAT}: array '{name}' is {tensor.dtype} of shape "
            f"{tuple(tensor.shape)}, float32 of shape {shape} is expected"
        )
    if not bool(tensor.isfinite().all()):
        raise InputError(f"{source}: array '{name}' holds NaN or infinity; train the scene again")


def _part(tensors: Mapping[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {
        name.removeprefix(prefix): value
        for name, value in tensors.items()
        if name.startswith(prefix)
    }


def _sky(part: Mapping[str, Tensor]) -> Sky:
    first, last = part["azimuth_rad"].tolist()
    dome = SkyDome(part["centre"], float(part["radius"]), (first, last))
    rows = {attribute.name: part[attribute.name] for attribute in SKY}
    return Sky(dome, Rows(sky.PREFIX, rows))
