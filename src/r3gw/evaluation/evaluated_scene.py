"""What every protocol looks at: the model, the scene's photos, their masks and true lights."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Bool, Float

from r3gw.evaluation.metrics import evaluation_mask
from r3gw.imaging.files import read_rgb
from r3gw.imaging.masks import read_mask
from r3gw.lighting.light import Light
from r3gw.masks.folder import load_masks
from r3gw.model.model import SceneModel
from r3gw.rendering.compose import render, sunlight_of
from r3gw.scene import GroundTruth, Scene, View


@dataclass(frozen=True)
class EvaluatedScene:
    """One trained model beside its scene.

    Attributes:
        model: The trained scene.
        scene: The imported scene.
        scene_folder: Folder of scene.json; the scene's paths are relative to it.
        masks_folder: Result of the mask stage: is_valid/ and is_sky/.
    """

    model: SceneModel
    scene: Scene
    scene_folder: Path
    masks_folder: Path

    @property
    def light_degree(self) -> int:
        """SH degree that lights are projected to: the model's own."""
        return self.model.description.light_degree

    def photo(self, view: View) -> Float[np.ndarray, "h w 3"]:
        """The view's photo, display values in [0, 1]."""
        return read_rgb(self.scene_folder / view.image).astype(np.float64) / 255.0

    def is_scored(self, view: View) -> Bool[np.ndarray, "h w"]:
        """The view's evaluation mask, eroded; the whole photo if it has none.

        Raises:
            InputError: If the mask is unreadable.
        """
        return scored_pixels(self.scene_folder, view)

    def masks(self, view: View) -> tuple[Bool[np.ndarray, "h w"], Bool[np.ndarray, "h w"]]:
        """``(is_valid, is_sky)``: no passer-by; sky.

        Raises:
            InputError: If a mask is missing or of another size than the photo.
        """
        return load_masks(self.masks_folder, view)

    def true_light(self, truth: GroundTruth) -> Light:
        """As the function `true_light`, in the model's degree."""
        return true_light(self.scene_folder, truth, self.light_degree)

    @torch.no_grad()
    def render(self, view: View, light: Light) -> Float[np.ndarray, "h w 3"]:
        """The view as training renders it, display values in [0, 1].

        Args:
            view: Which camera.
            light: With a learned sky, or with none: a white one, as the published protocol asks.
        """
        sunlight = sunlight_of(self.model, view.camera, light.point)
        lit = (light.sh, light.sky_coefficients)
        colour = render(self.model, view.camera, *lit, sunlight=sunlight).colour
        return colour.clamp(0.0, 1.0).double().numpy()


def true_light(scene_folder: Path, truth: GroundTruth, degree: int) -> Light:
    """Light of the true HDR map in the photo's own units (exposure, white balance), without a sky.

    Args:
        scene_folder: Folder of scene.json.
        truth: What is known of the photo.
        degree: Highest SH band.
    """
    light = _projected(scene_folder / truth.env_map, degree)
    balance = torch.tensor(truth.white_balance)
    point = None if light.point is None else light.point.times(truth.exposure * balance)
    return Light(light.sh * truth.exposure * balance, point=point)


def scored_pixels(scene_folder: Path, view: View) -> Bool[np.ndarray, "h w"]:
    """The view's evaluation mask, eroded; the whole photo if it has none.

    Raises:
        InputError: If the mask is unreadable.
    """
    if view.evaluation is None or view.evaluation.mask is None:
        return np.ones((view.height, view.width), np.bool_)
    given = read_mask(scene_folder / view.evaluation.mask)
    return evaluation_mask(given, view.width, view.height)


@lru_cache(maxsize=64)
def _projected(path: Path, degree: int) -> Light:
    return Light.from_map(path, degree=degree).with_sky(None)
