"""A trained scene in use: `load` it, look at its cameras and lights, render it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float32

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.lighting.light import Light
from r3gw.relight.cameras import view_named
from r3gw.relight.gaussians import Relightable
from r3gw.relight.lights import learned_strength
from r3gw.relight.load import load_relightable, model_in, scene_beside
from r3gw.relight.picture import frame
from r3gw.relight.seen import Coverage
from r3gw.relight.tone import CURVES, linear_from_scene, scene_linear
from r3gw.relight.witnesses import Witnesses
from r3gw.scene import Scene, load_scene

Tone = Literal["standard", "reinhard", "filmic", "linear"]


@dataclass(frozen=True, eq=False)
class TrainedScene:
    """A trained scene, ready to be rendered.

    Attributes:
        gaussians: What is rendered.
        scene: The imported scene with the photos' cameras; None where only a model is at hand.
    """

    gaussians: Relightable
    scene: Scene | None

    def __repr__(self) -> str:
        """One line: the arrays would fill pages of a notebook."""
        count, sky = self.gaussians.num_foreground, self.gaussians.num_sky
        return (
            f"<TrainedScene of {self.gaussians.origin}: {count:,} foreground and {sky:,} sky "
            f"Gaussians, {len(self.cameras)} cameras, {len(self.lights)} lights>"
        )

    @cached_property
    def cameras(self) -> Mapping[str, Camera]:
        """The photos' cameras by the photos' names; empty without an imported scene."""
        views = () if self.scene is None else self.scene.views
        return {view.name: view.camera for view in views}

    @cached_property
    def witnesses(self) -> Witnesses:
        """The photos that the scene was trained on; none without an imported scene."""
        views = () if self.scene is None else self.scene.split("train")
        return Witnesses(self.gaussians, [view.camera for view in views])

    @cached_property
    def coverage(self) -> Coverage:
        """What the photos that the scene was trained on saw of it."""
        views = () if self.scene is None else self.scene.split("train")
        return Coverage(self.gaussians, [view.camera for view in views])

    @property
    def lights(self) -> Mapping[str, Light]:
        """The lights that were learned for training photos, by the photos' names."""
        return self.gaussians.lights

    def render(
        self,
        camera: Camera | str,
        light: Light | str,
        *,
        sky: Light | Literal["own", "white"] = "own",
        tone: Tone = "standard",
    ) -> Float32[np.ndarray, "h w 3"]:
        """One picture.

        Args:
            camera: Where from; a photo's name stands for its camera.
            light: What lights the scene; a training photo's name stands for the light that was
                learned for it.
            sky: What is seen behind the scene: the light's own sky, paper white, or another
                light's sky.
            tone: ``standard`` clamps, as in training; ``reinhard`` and ``filmic`` are softer.
                ``linear`` returns linear radiance without an upper end.

        Returns:
            Display values in [0, 1], or linear radiance.

        Raises:
            InputError: If a name is unknown.
        """
        if isinstance(camera, str):
            camera = self.camera(camera)
        if isinstance(light, str):
            light = self.gaussians.light_of(light)
        if sky != "own":
            light = light.with_sky(sky.sky if isinstance(sky, Light) else None)
        curve = scene_linear if tone == "linear" else CURVES[tone]
        picture = frame(self.gaussians, camera, light, curve, self.witnesses)
        shown = linear_from_scene(picture) if tone == "linear" else picture.clamp(0.0, 1.0)
        return np.asarray(shown.numpy(), np.float32)

    def camera(self, name: str) -> Camera:
        """The camera of a photo.

        Raises:
            InputError: If there is no photo of that name, or no imported scene.
        """
        if self.scene is None:
            raise InputError(
                f"{self.gaussians.origin}: no cameras are known; load it with the folder of its "
                "scene.json"
            )
        return view_named(self.scene, name).camera

    def well_seen(self, camera: Camera | str) -> float | None:
        """Share of the surfaces in a picture that two photos saw from within 30 degrees.

        The rest is a guess, however sharp it looks.

        Args:
            camera: Where from; a photo's name stands for its camera.

        Returns:
            0 to 1, or None where the picture shows no surface.

        Raises:
            InputError: If a name is unknown, or no photo's camera is known.
        """
        if self.scene is None:
            raise InputError(
                f"{self.gaussians.origin}: no cameras are known; load it with the folder of its "
                "scene.json"
            )
        return self.coverage.share(self.camera(camera) if isinstance(camera, str) else camera)

    def exposed(self, light: Light) -> Light:
        """A light from elsewhere, made as strong as the learned lights are in the median.

        Maps are in units of their own, so they seldom suit the scene's photos as they are.

        Raises:
            InputError: If the scene has no learned lights.
        """
        return light.times(light.factor_to(learned_strength(self.gaussians)))


def load(path: str | Path, scene: str | Path | None = None) -> TrainedScene:
    """Open a trained scene.

    Args:
        path: model.safetensors of a training, the folder that holds it, or relightable.ply of an
            export.
        scene: Folder of scene.json, for the photos' cameras. By default it is looked for where the
            workflow puts it: ``results/SCENE/scene`` beside ``results/SCENE/VARIANT/SEED``.

    Raises:
        InputError: If a file is missing or of another kind.
    """
    model = Path(path)
    if model.is_dir():
        model = model_in(model)
    folder = scene_beside(model.parent) if scene is None else Path(scene)
    is_known = scene is not None or (folder / "scene.json").is_file()
    return TrainedScene(load_relightable(model), load_scene(folder) if is_known else None)
