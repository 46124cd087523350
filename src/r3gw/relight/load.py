"""Where a scene to be shown comes from: a training's model.safetensors or an exported PLY file."""

from pathlib import Path

from r3gw.files import InputError
from r3gw.model.model_file import load_model
from r3gw.relight.files.ply import read_ply
from r3gw.relight.gaussians import Relightable, relightable_of
from r3gw.scene import Scene

MODELS = ("model.safetensors", "model.pt")  # the newer format first


def load_relightable(path: Path) -> Relightable:
    """Read ``model.safetensors``, or a relightable ``.ply`` with its ``lights.json`` beside it.

    Raises:
        InputError: If the file is missing or of another kind.
    """
    if path.suffix.lower() == ".ply":
        return read_ply(path)
    return relightable_of(load_model(path), str(path))


def require_scene_of(gaussians: Relightable, scene: Scene) -> None:
    """Refuse a scene that has none of the photos that the Gaussians were trained on.

    Raises:
        InputError: If so: cameras of one place would look at another.
    """
    if gaussians.lights and not any(view.name in gaussians.lights for view in scene.views):
        raise InputError(
            f"{gaussians.origin}: was trained on other photos than those of scene '{scene.name}' "
            f"(on {next(iter(gaussians.lights))}, among others); give the --scene that it was "
            "trained on"
        )


def model_in(folder: Path) -> Path:
    """The model of a run's folder; where there is none yet, the one that training will write."""
    present = (folder / name for name in MODELS if (folder / name).is_file())
    return next(present, folder / MODELS[0])


def scene_beside(run: Path) -> Path:
    """Where the workflow puts a run's scene: ``results/SCENE/scene`` of a run's folder."""
    return run.resolve().parent.parent / "scene"
