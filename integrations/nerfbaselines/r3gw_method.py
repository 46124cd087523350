"""r3gw behind the interface of NerfBaselines: training step by step, renders, fitted lights.

An embedding is what lights a picture, as one vector: the coefficients of the light, then those of
the sky. That of a training photo is the light learned for it; for other photos it is fitted.
"""

from pathlib import Path
from typing import Any

import numpy as np
import torch
from nerfbaselines import Cameras, Dataset, Method

from r3gw.evaluation.fitted_light import Target, fitted_light
from r3gw.files import write_json
from r3gw.files.strict import read_json, read_yaml, validated
from r3gw.geometry.cameras import Camera
from r3gw.importing.gauge import scene_from_source, upright_rotation
from r3gw.importing.source import SourcePoints
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.masks.classical import segment_sky
from r3gw.model.initial import initial_points
from r3gw.model.lights import photo_light
from r3gw.model.model_file import load_model, save_model
from r3gw.rendering.compose import render
from r3gw.scene import Gauge
from r3gw.training.loop import step
from r3gw.training.photos import Photo, camera_extent
from r3gw.training.resolution import PhotoSizes
from r3gw.training.schedule import Schedule
from r3gw.training.settings import TrainSettings
from r3gw.training.start import initial_model
from r3gw.training.state import first_state
from r3gw.training.visible_sky import visible_sky

CONFIG = Path(__file__).parents[2] / "config"
EXTENT = 10.0  # of the scene, as r3gw scales what it imports
SKY_COEFFICIENTS = 4
INFO = {
    "method_id": "r3gw",
    "required_features": frozenset(("color", "points3D_xyz")),
    "supported_camera_models": frozenset(("pinhole",)),
    "supported_outputs": ("color", "accumulation"),
    "can_resume_training": False,
}


class R3gwMethod(Method):
    """One training, or one trained scene."""

    def __init__(
        self,
        *,
        checkpoint: str | None = None,
        train_dataset: Dataset | None = None,
        config_overrides: dict[str, Any] | None = None,
    ) -> None:
        """Prepare a training on a dataset, or open what `save` wrote."""
        self._loaded_step = None
        if checkpoint is not None:
            folder = Path(checkpoint)
            self._model = load_model(folder / "model.safetensors")
            kept = read_json(folder / "nerfbaselines.json")
            self._scene_from_source = validated(Gauge, kept["gauge"], checkpoint).similarity
            self._settings = validated(TrainSettings, kept["settings"], checkpoint)
            self._loaded_step = self._settings.iterations
        elif train_dataset is not None:
            self._settings = settings_with(config_overrides or {})
            self._begin(train_dataset)

    def _begin(self, dataset: Dataset) -> None:
        """Bring the dataset into r3gw's frame and build the model that training starts from."""
        cameras, xyz = dataset["cameras"], np.asarray(dataset["points3D_xyz"], np.float64)
        poses = [cam_from_source(pose) for pose in cameras.poses]
        turn = upright_rotation(np.stack([pose[:3, :3].numpy() for pose in poses]))
        points = SourcePoints(xyz, np.zeros(xyz.shape, np.uint8))
        self._scene_from_source = scene_from_source(points, turn, EXTENT)
        masks = dataset["masks"] or [None] * len(cameras)
        self._photos = [
            photo_of(Path(path).stem, self._camera(camera), pixels, mask)
            for path, camera, pixels, mask in zip(
                dataset["image_paths"], cameras, dataset["images"], masks, strict=True
            )
        ]
        start = initial_points(
            self._scene_from_source.points(torch.from_numpy(xyz).float()),
            [photo.camera for photo in self._photos],
            self._settings.sky,
            seed=0,
        )
        names = tuple(photo.name for photo in self._photos)
        skies = [photo.seen_sky for photo in self._photos]
        self._model = initial_model(start, names, self._settings, None, skies)
        self._state = first_state(self._model, self._settings)
        self._schedule = Schedule.of(self._settings)
        self._sizes = PhotoSizes(self._photos, self._schedule)
        self._extent = camera_extent([photo.camera for photo in self._photos])

    @classmethod
    def get_method_info(cls) -> dict[str, Any]:
        """What datasets have to bring."""
        return dict(INFO)

    def get_info(self) -> dict[str, Any]:
        """What is trained, and how long."""
        return INFO | {
            "num_iterations": self._settings.iterations,
            "loaded_step": self._loaded_step,
            "batch_size": 1,
            "eval_batch_size": 1,
            "hparams": self._settings.model_dump(mode="json"),
        }

    def train_iteration(self, step: int) -> dict[str, float]:  # noqa: ARG002  The interface's.
        """Do one iteration; which one it is, the state of the training knows."""
        self._model.appearance.train()
        row = do_step(self._state, self._sizes, self._schedule, self._extent)
        self._model.appearance.eval()
        return {name: float(row[name]) for name in ("loss", "psnr")} if row else {}

    def get_train_embedding(self, index: int) -> np.ndarray:
        """The light that was learned for a training photo."""
        return vector_of(photo_light(self._model, self._model.photos[index]))

    def optimize_embedding(
        self, dataset: Dataset, *, embedding: np.ndarray | None = None
    ) -> dict[str, Any]:
        """Fit a light to one photo, from the learned lights or from ``embedding``."""
        camera = self._camera(dataset["cameras"].item())
        photo = torch.from_numpy(np.asarray(dataset["images"][0])[..., :3]).float() / 255.0
        masks = dataset["masks"]
        mask = np.ones(photo.shape[:2], bool) if masks is None else np.asarray(masks[0]) > 0
        starts = [photo_light(self._model, name) for name in self._model.photos]
        if embedding is not None:
            starts = [light_of(embedding)]
        target = Target(camera, photo, torch.from_numpy(mask))
        return {"embedding": vector_of(fitted_light(self._model, target, starts))}

    @torch.no_grad()
    def render(self, camera: Cameras, *, options: dict[str, Any] | None = None) -> dict[str, Any]:
        """One picture, under the light of ``options["embedding"]``.

        Without one: the mean of the learned lights.
        """
        embedding = (options or {}).get("embedding")
        if embedding is None:
            count = len(self._model.photos)
            embedding = np.mean([self.get_train_embedding(i) for i in range(count)], axis=0)
        light = light_of(embedding)
        rendering = render(
            self._model, self._camera(camera.item()), light.sh, light.sky.coefficients
        )
        return {
            "color": rendering.colour.clamp(0.0, 1.0).numpy(),
            "accumulation": rendering.alpha.numpy(),
        }

    def save(self, path: str) -> None:
        """Write the model, the settings and the frame into a folder."""
        folder = Path(path)
        folder.mkdir(parents=True, exist_ok=True)
        settings = self._settings.model_dump(mode="json")
        save_model(self._model, folder / "model.safetensors", settings)
        gauge = Gauge.of(self._scene_from_source).model_dump(mode="json")
        write_json(folder / "nerfbaselines.json", {"gauge": gauge, "settings": settings})

    def _camera(self, camera: Cameras) -> Camera:
        """A camera of NerfBaselines in the scene's frame."""
        width, height = (int(size) for size in camera.image_sizes)
        intrinsics = tuple(float(value) for value in camera.intrinsics)
        moved = self._scene_from_source.camera(cam_from_source(camera.poses))
        return Camera(moved, intrinsics, width, height)


def do_step(*arguments: Any) -> dict[str, float | int] | None:
    """`r3gw.training.loop.step` with nobody watching."""
    return step(*arguments, None)


def settings_with(overrides: dict[str, Any]) -> TrainSettings:
    """config/train.yaml with changes such as ``{"rates.scale": 0.02}`` on top.

    Raises:
        InputError: If a key is unknown or a value out of range.
    """
    values = read_yaml(CONFIG / "train.yaml")
    for name, value in overrides.items():
        *groups, key = name.split(".")
        place = values
        for group in groups:
            place = place.setdefault(group, {})
        place[key] = value
    return validated(TrainSettings, values, "config overrides")


def cam_from_source(pose: np.ndarray) -> torch.Tensor:
    """Invert a pose ``[3, 4]``, world from camera (x right, y down, z forward); ``[4, 4]``."""
    whole = torch.eye(4, dtype=torch.float64)
    whole[:3] = torch.from_numpy(np.asarray(pose, np.float64)[:3, :4])
    return torch.linalg.inv(whole)


def photo_of(name: str, camera: Camera, pixels: np.ndarray, mask: np.ndarray | None) -> Photo:
    """A training photo with its masks; the sky is found in the picture."""
    rgb = np.ascontiguousarray(pixels[..., :3])
    is_sky = torch.from_numpy(segment_sky(rgb))
    is_valid = torch.ones_like(is_sky) if mask is None else torch.from_numpy(np.asarray(mask) > 0)
    planes = torch.from_numpy(np.moveaxis(rgb, -1, 0).copy())
    seen = visible_sky(camera, planes, is_sky & is_valid)
    return Photo(name, camera, planes, is_valid, is_sky, seen)


def vector_of(light: Light) -> np.ndarray:
    """A light with its learned sky as one vector."""
    parts = torch.cat([light.sh.flatten(), light.sky.coefficients.flatten()])
    return parts.detach().numpy().astype(np.float32)


def light_of(vector: np.ndarray) -> Light:
    """The light that `vector_of` wrote."""
    rows = torch.from_numpy(np.asarray(vector, np.float32)).reshape(-1, 3)
    return Light(rows[:-SKY_COEFFICIENTS], LearnedSky(rows[-SKY_COEFFICIENTS:]))
