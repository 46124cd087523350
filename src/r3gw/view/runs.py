"""Which files a page is made of, from what somebody names on the command line."""

import json
from dataclasses import dataclass
from pathlib import Path

from r3gw.files import InputError
from r3gw.relight.load import model_in, scene_beside

FACTS = {"variant": "variant", "iterations": "iterations", "code_version": "code"}


@dataclass(frozen=True)
class Run:
    """A run's files.

    Attributes:
        folder: The run's folder.
        model: model.safetensors, model.pt or relightable.ply; it may not exist yet.
        scene: Folder of scene.json.
    """

    folder: Path
    model: Path
    scene: Path

    @property
    def is_trained(self) -> bool:
        """Whether the model is there."""
        return self.model.is_file()

    @property
    def facts(self) -> tuple[str, ...]:
        """What run.json says, as lines for the page."""
        path = self.folder / "run.json"
        if not path.is_file():
            return ()
        record = json.loads(path.read_text())
        found = [f"{title} {record[key]}" for key, title in FACTS.items() if key in record]
        return (f"Trained by r3gw: {', '.join(found)}.",) if found else ()


def find_run(path: Path, scene: Path | None) -> Run:
    """The run of a folder, or of a model's file.

    Args:
        path: A run's folder (results/SCENE/VARIANT/seed0), model.safetensors or relightable.ply.
        scene: Folder of scene.json; None looks where the workflow puts it, two folders above.

    Raises:
        InputError: If the path or the scene is missing.
    """
    if not path.exists():
        raise InputError(
            f"{path}: no such file or folder; give a run's folder or its model.safetensors"
        )
    folder = path if path.is_dir() else path.parent
    if path.is_dir() and not model_in(path).is_file():
        raise InputError(
            f"{path}: holds no {model_in(path).name}; give a run's folder, such as "
            "results/SCENE/VARIANT/seed0"
        )
    found = scene or scene_beside(folder)
    if not (found / "scene.json").is_file():
        raise InputError(f"{found / 'scene.json'}: no such file; name the scene with --scene")
    return Run(folder, model_in(path) if path.is_dir() else path, found)
