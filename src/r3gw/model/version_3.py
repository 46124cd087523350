"""Reading ``model.pt``, the model file of version 3: torch's own format, settings included.

Only data is read (``weights_only``): a file that would run code is refused.
"""

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from r3gw.files import InputError
from r3gw.files.arrays import LARGEST_BYTES, require_size

VERSION = 3
FIRST_BYTES = b"PK\x03\x04"


def is_version_3(path: Path) -> bool:
    """Whether a file is a ZIP archive, as torch writes; a file of arrays never begins like one."""
    with path.open("rb") as stream:
        return stream.read(len(FIRST_BYTES)) == FIRST_BYTES


def read_version_3(path: Path) -> tuple[dict[str, Tensor], dict[str, Any]]:
    """Arrays and plain values of a model of version 3, under the names of `r3gw.model.model_file`.

    Raises:
        InputError: If the file is too large, damaged, or of another version.
    """
    content = _loaded(path)
    if content.get("version") != VERSION:
        raise InputError(
            f"{path}: model file version {content.get('version')!r}, but a .pt file is read "
            f"in version {VERSION} alone; train the scene again"
        )
    try:
        return _tensors(content), _values(content)
    except (KeyError, TypeError, AttributeError, StopIteration) as error:
        raise InputError(f"{path}: damaged, or no model of r3gw ({error!r:.120})") from None


def _loaded(path: Path) -> dict[str, Any]:
    require_size(path, LARGEST_BYTES)
    try:
        with zipfile.ZipFile(path) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
        if unpacked > LARGEST_BYTES:
            raise InputError(f"{path}: {unpacked / 1e9:.1f} GB unpacked, more than are read")
        content = torch.load(path, weights_only=True, map_location="cpu")
    except InputError:
        raise
    except Exception as error:
        reason = str(error).split("\n")[0][:120] or type(error).__name__
        raise InputError(f"{path}: damaged, or no model of r3gw ({reason})") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: no model of r3gw: it holds a {type(content).__name__}")
    return content


def _tensors(content: Mapping[str, Any]) -> dict[str, Tensor]:
    """Arrays under their names of today; old prefixes on the left."""
    prefixes = {
        "foreground": {"values.": "foreground."},
        "sky": {"rows.values.": "sky.", "": "sky."},
        "appearance": {"outdoor.": "appearance.light_model.", "": "appearance."},
    }
    tensors: dict[str, Tensor] = {}
    for part, renamed in prefixes.items():
        for name, value in content[part].items():
            old = next(prefix for prefix in renamed if name.startswith(prefix))
            tensors[f"{renamed[old]}{name.removeprefix(old)}"] = value
    return tensors


def _values(content: Mapping[str, Any]) -> dict[str, Any]:
    """What version 3 left to be read from the settings of the training."""
    settings = content["settings"]
    model, outdoor = settings["model"], settings["outdoor"]
    light = {"kind": "free", "degree": model["light_degree"]}
    if outdoor["enabled"]:
        light |= {"kind": "outdoor", "ground_reflectance": outdoor["ground_reflectance"]}
    same = ("separate_sky", "specular", "share_session_light")
    sizes = ("embedding_size", "hidden_size", "light_hidden_size")
    description = {name: model[name] for name in (*same, *sizes)} | {"light": light}
    return {
        "description": description,
        "photos": content["photos"],
        "sessions": content["sessions"],
    }
