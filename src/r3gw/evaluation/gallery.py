"""Pictures of a scene relit: by one map turned around the circle, and by learned lights.

``map/<view>_<yaw>.png`` and ``map/light_<yaw>.png`` show two views and the map, which turns about
the vertical towards its right; ``learned/<view>_<n>.png`` and ``learned/light_<n>.png`` the same
views under lights that were learned for photos, with those photos' skies. relit.json names them.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from numpy.typing import NDArray
from torch import Tensor

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.files import write_json
from r3gw.imaging.colour import display_array_from_linear
from r3gw.imaging.files import write_image
from r3gw.imaging.pictures import bytes_from_display
from r3gw.lighting import envmap
from r3gw.lighting.light import Light
from r3gw.lighting.maps import linear_env_map
from r3gw.model.lights import learned_lights, learned_strength
from r3gw.relight.gaussians import Relightable, relightable_of
from r3gw.relight.picture import frame
from r3gw.relight.tone import standard
from r3gw.relight.witnesses import Witnesses
from r3gw.scene import View
from r3gw.scene.selection import evenly

NUM_YAWS = 24
NUM_VIEWS = 2
NUM_LIGHTS = 6
THUMBNAIL_PX = 64
BRIGHTEST_QUANTILE = 0.98

Source = tuple[str, Light, Float[Tensor, "h w 3"]]


def write_gallery(evaluated: EvaluatedScene, folder: Path) -> None:
    """Render two views under a turning map and under learned lights; relit.json is last."""
    views = evenly(evaluated.scene.split("test") or evaluated.scene.split("train"), NUM_VIEWS)
    gaussians = relightable_of(evaluated.model)
    witnesses = Witnesses(gaussians, [view.camera for view in evaluated.scene.split("train")])
    name, light, env_map = _map_source(evaluated)
    yaws_deg = [round(360 * i / NUM_YAWS) for i in range(NUM_YAWS)]
    for yaw_deg in yaws_deg:
        shift = round(env_map.shape[1] * yaw_deg / 360)
        thumbnail = light_picture(env_map.roll(shift, dims=1))
        write_image(folder / "map" / f"light_{yaw_deg:03d}.png", thumbnail)
        for view in views:
            path = folder / "map" / f"{view.name}_{yaw_deg:03d}.png"
            write_image(
                path, relit_picture(gaussians, view, light.turned(float(yaw_deg)), witnesses)
            )
    photos = _photos_of_sessions(evaluated.scene.split("train"))
    for number, photo in enumerate(photos):
        learned = gaussians.light_of(photo)
        drawn = light_picture(envmap.draw(learned.sh, THUMBNAIL_PX))
        write_image(folder / "learned" / f"light_{number}.png", drawn)
        for view in views:
            path = folder / "learned" / f"{view.name}_{number}.png"
            write_image(path, relit_picture(gaussians, view, learned, witnesses))
    names = [view.name for view in views]
    write_json(
        folder / "relit.json",
        {"views": names, "map": name, "yaws_deg": yaws_deg, "photos": photos},
    )


def relit_picture(
    gaussians: Relightable, view: View, light: Light, witnesses: Witnesses
) -> NDArray[np.uint8]:
    """A view under a light as `python -m r3gw relight` shows it."""
    return bytes_from_display(frame(gaussians, view.camera, light, standard, witnesses))


def light_picture(env_map: Float[Tensor, "h w 3"]) -> NDArray[np.uint8]:
    """A small picture of a linear map, its 98th percentile white: ``[64, 128, 3]``."""
    resized = torch.nn.functional.interpolate(
        env_map.permute(2, 0, 1)[None], (THUMBNAIL_PX, 2 * THUMBNAIL_PX), mode="area"
    )[0].permute(1, 2, 0)
    white = max(float(resized.quantile(BRIGHTEST_QUANTILE)), 1e-6)
    return bytes_from_display(display_array_from_linear((resized / white).numpy()))


def _photos_of_sessions(views: Sequence[View]) -> list[str]:
    """One photo per session, or any photos where sessions are unknown."""
    first = {view.session or view.name: view.name for view in reversed(views)}
    return evenly(sorted(first.values()), NUM_LIGHTS)


def _map_source(evaluated: EvaluatedScene) -> Source:
    """The most directional of the maps that come with the scene; else of the learned lights."""
    test = evaluated.scene.split("test")
    sources = [_map_of(evaluated, view) for view in test if view.truth or view.evaluation]
    if not sources:
        for photo, light in learned_lights(evaluated.model).items():
            drawn = envmap.draw(light.sh, THUMBNAIL_PX)
            sources.append((f"light learned for {photo}", light.with_sky(None), drawn))
    return max(sources, key=lambda source: _directionality(source[1].sh))


def _directionality(light: Float[Tensor, "coeff 3"]) -> float:
    """Strength of band 1 over that of band 0: 0 for a uniform light."""
    return float(light[1:4].norm() / light[0].norm())


def _map_of(evaluated: EvaluatedScene, view: View) -> Source:
    """A test view's true HDR map in the photo's units, or its LDR map; the sky stays white.

    An LDR map knows no units, so it is brought to the mean strength of the learned lights.
    """
    if view.truth is not None:
        path = evaluated.scene_folder / view.truth.env_map
        name = f"true map of {view.session or view.name}"
        return name, evaluated.true_light(view.truth), envmap.read_env_map(path)
    assert view.evaluation is not None  # the caller's choice
    path = evaluated.scene_folder / view.evaluation.env_map
    env_map = linear_env_map(path)
    light = Light.from_pixels(env_map, degree=evaluated.light_degree).with_sky(None)
    exposure = light.factor_to(learned_strength(evaluated.model))
    return f"map of {view.session or view.name}", light.times(exposure), env_map
