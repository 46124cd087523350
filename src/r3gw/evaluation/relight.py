"""Relighting for users: a trained scene under an environment map or under a photo's light."""

from math import radians
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from numpy.typing import NDArray
from torch import Tensor

from r3gw.evaluation.lights import map_light, photo_light
from r3gw.evaluation.pictures import bytes_from_display
from r3gw.files import InputError
from r3gw.gaussians.compose import render
from r3gw.gaussians.model import SceneModel, load_model
from r3gw.geometry.cameras import Camera
from r3gw.imaging.files import write_image
from r3gw.scene import View, load_scene

WHITE_SKY = "white"
LEARNED_SKY = "learned:"


@torch.no_grad()
def relight(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "skycoeff 3"] | None,
) -> NDArray[np.uint8]:
    """Picture ``[H, W, 3]`` of the scene under a light; without sky light the sky is white."""
    return bytes_from_display(render(model, camera, light, sky_light).colour)


def relight_view(
    model_path: Path,
    scene_folder: Path,
    view: str,
    output: Path,
    *,
    env_map: Path | None = None,
    yaw_deg: float = 0.0,
    exposure: float = 1.0,
    light_of: str | None = None,
    sky: str | None = None,
) -> None:
    """Write a view of the scene, relit.

    Args:
        model_path: model.pt of a training.
        scene_folder: Folder of scene.json.
        view: Name of the training or test view whose camera is used.
        output: Picture to write (.png or .jpg).
        env_map: Environment map that lights the scene; or
        light_of: training photo whose learned light does. Exactly one of the two.
        yaw_deg, exposure: Of the map (`map_light`).
        sky: ``white`` or ``learned:PHOTO``. By default white under a map, and the photo's own
            under a learned light.

    Raises:
        InputError: If a name is unknown, a file unreadable, or not exactly one light is given.
    """
    if (env_map is None) == (light_of is None):
        raise InputError("relighting needs one light: give either --env-map or --light-of")
    model = load_model(model_path)
    camera = _view_named(scene_folder, view).camera
    sky_light = None
    if env_map is not None:
        degree = model.settings.model.light_degree
        light = map_light(env_map, degree, yaw_rad=radians(yaw_deg), exposure=exposure)
    else:
        assert light_of is not None  # for the type checker
        light, sky_light = photo_light(model, light_of)
    if sky is not None:
        sky_light = _sky_named(model, sky)
    write_image(output, relight(model, camera, light, sky_light))


def _view_named(scene_folder: Path, name: str) -> View:
    views = {view.name: view for view in load_scene(scene_folder).views}
    if name not in views:
        raise InputError(
            f"{scene_folder / 'scene.json'}: has no view '{name}'; it has {', '.join(views)}"
        )
    return views[name]


def _sky_named(model: SceneModel, sky: str) -> Float[Tensor, "skycoeff 3"] | None:
    if sky == WHITE_SKY:
        return None
    if sky.startswith(LEARNED_SKY):
        return photo_light(model, sky.removeprefix(LEARNED_SKY))[1]
    raise InputError(f"sky '{sky}' is unknown; use '{WHITE_SKY}' or '{LEARNED_SKY}PHOTO'")
