"""The initialise stage: imported scene in, ``initial.npz`` out."""

from pathlib import Path

import torch

from r3gw.model.initial import initial_points, save_initial
from r3gw.model.settings import SkySettings
from r3gw.scene import load_points, load_scene

# Seeds of runs vary what is random in training; all runs of a scene start from the same points.
SKY_SEED = 0


def run_initialise(scene_folder: Path, settings: SkySettings, target: Path) -> None:
    """Write the initial points of a scene.

    Raises:
        InputError: If the scene is missing or malformed, or has no points.
    """
    cameras = [view.camera for view in load_scene(scene_folder).split("train")]
    xyz = torch.from_numpy(load_points(scene_folder).xyz)
    save_initial(initial_points(xyz, cameras, settings, SKY_SEED), target)
