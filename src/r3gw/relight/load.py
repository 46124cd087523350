"""Where a scene to be shown comes from: a training's model.safetensors or an exported PLY file."""

from pathlib import Path

from r3gw.model.model_file import load_model
from r3gw.relight.files.ply import read_ply
from r3gw.relight.gaussians import Relightable, relightable_of


def load_relightable(path: Path) -> Relightable:
    """Read ``model.safetensors``, or a relightable ``.ply`` with its ``lights.json`` beside it.

    Raises:
        InputError: If the file is missing or of another kind.
    """
    if path.suffix.lower() == ".ply":
        return read_ply(path)
    return relightable_of(load_model(path), str(path))
