"""The initialise stage: imported scene in, ``initial.npz`` out."""

from pathlib import Path

import torch

from r3gw.model.initial import initial_points, save_initial
from r3gw.model.settings import SkySettings
from r3gw.scene import load_points, load_scene
from r3gw.stereo.points import dense_points

# Seeds of runs vary what is random in training; all runs of a scene start from the same points.
SKY_SEED = 0


def run_initialise(
    scene_folder: Path, settings: SkySettings, target: Path, masks_folder: Path | None = None
) -> None:
    """Write the initial points of a scene.

    Args:
        scene_folder: The imported scene.
        settings: How the sky's Gaussians are placed.
        target: ``initial.npz``.
        masks_folder: Its masks: then stereo between the training photos adds points to the sparse
            ones. None takes the sparse ones alone.

    Raises:
        InputError: If the scene is missing or malformed, or has no points; with masks, if a photo
            or mask is missing.
    """
    scene = load_scene(scene_folder)
    cameras = [view.camera for view in scene.split("train")]
    xyz = torch.from_numpy(load_points(scene_folder).xyz)
    if masks_folder is not None:
        # On one thread, sums have one order: the same photos give the same points anywhere.
        torch.set_num_threads(1)
        xyz = torch.cat([xyz, dense_points(scene, scene_folder, masks_folder, xyz)])
    save_initial(initial_points(xyz, cameras, settings, SKY_SEED), target)
