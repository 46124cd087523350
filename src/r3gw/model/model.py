"""The whole learned scene and its file, ``model.pt``."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError, atomic_path
from r3gw.lighting import sh
from r3gw.lighting.outdoor import SKY_DEGREE
from r3gw.model.appearance import Appearance
from r3gw.model.foreground import initial_foreground
from r3gw.model.initial import InitialPoints
from r3gw.model.outdoor import OutdoorLight
from r3gw.model.rows import OCCLUSION, Rows
from r3gw.model.settings import TrainSettings
from r3gw.model.sky import Sky, SkyDome

FILE_VERSION = 3


@dataclass
class SceneModel:
    """A relightable scene.

    Attributes:
        foreground: Rows ``means, log_scales, quaternions, opacity_logits, albedo_logits,
            roughness_logits``.
        sky: Sky Gaussians; empty for a single-set model.
        appearance: Light and sky colour per training photo.
        photos: Names of the training photos, in the order of the embedding.
        sessions: The photos' sessions, in the same order.
        settings: The settings of the run.
    """

    foreground: Rows
    sky: Sky
    appearance: Appearance
    photos: tuple[str, ...]
    sessions: tuple[str, ...]
    settings: TrainSettings

    @property
    def num_gaussians(self) -> int:
        """Foreground and sky together."""
        return len(self.foreground) + len(self.sky.rows)


def initial_model(
    initial: InitialPoints,
    photos: tuple[str, ...],
    settings: TrainSettings,
    sessions: tuple[str, ...] | None = None,
    first_skies: Float[Tensor, "s 4 3"] | None = None,
) -> SceneModel:
    """Build the model that training starts from.

    Args:
        initial: Points of both sets.
        photos: Names of the training photos.
        settings: The settings of the run.
        sessions: The photos' sessions; by default each photo is a session of its own.
        first_skies: One per row of `light_rows`: where an outdoor light starts; even by default.
    """
    sessions = photos if sessions is None else sessions
    generator = torch.Generator().manual_seed(settings.seed)
    dome, points, angles = initial.dome, initial.foreground, initial.sky_angles
    if not settings.model.separate_sky:
        points = torch.cat([points, initial.sky_points()])
        angles = angles[:0]
    appearance = _appearance(sessions, settings, generator, first_skies)
    foreground = initial_foreground(points, settings.init)
    if settings.occlusion.enabled:
        size = sh.num_coefficients(settings.model.light_degree)
        foreground.add_computed(OCCLUSION, torch.zeros(len(points), size))
    return SceneModel(
        foreground,
        Sky(dome, angles, settings.init.opacity),
        appearance,
        photos,
        sessions,
        settings,
    )


def light_rows(sessions: tuple[str, ...], settings: TrainSettings) -> list[int]:
    """Which embedding each photo uses: its own, or its session's if the settings share light."""
    if not settings.model.share_session_light:
        return list(range(len(sessions)))
    known = list(dict.fromkeys(sessions))
    return [known.index(session) for session in sessions]


def _appearance(
    sessions: tuple[str, ...],
    settings: TrainSettings,
    generator: torch.Generator,
    first_skies: Float[Tensor, "s 4 3"] | None = None,
) -> Appearance:
    rows, degree = light_rows(sessions, settings), settings.model.light_degree
    if not settings.outdoor.enabled:
        first = sh.constant(settings.init.light_radiance, degree)
        return Appearance(rows, settings.model, first, generator)
    if first_skies is None:
        first_skies = sh.constant(settings.init.light_radiance, SKY_DEGREE).repeat(
            max(rows) + 1, 1, 1
        )
    power, reflectance = settings.outdoor.sun_power, settings.outdoor.ground_reflectance
    light = OutdoorLight(first_skies, power, reflectance, degree)
    return Appearance(rows, settings.model, light, generator)


def model_content(model: SceneModel) -> dict[str, Any]:
    """The model as tensors and plain values, for a file."""
    return {
        "version": FILE_VERSION,
        "foreground": model.foreground.state_dict(),
        "sky": model.sky.state_dict(),
        "appearance": model.appearance.state_dict(),
        "photos": list(model.photos),
        "sessions": list(model.sessions),
        "settings": model.settings.model_dump(mode="json"),
    }


def save_model(model: SceneModel, path: Path) -> None:
    """Write the model atomically."""
    # A stream, because torch writes the name of a path, here a temporary one, into the file.
    with atomic_path(path) as temporary, temporary.open("wb") as stream:
        torch.save(model_content(model), stream)


def load_model(path: Path) -> SceneModel:
    """Read a model written by `save_model`.

    Raises:
        InputError: If the file is missing or of another version.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such model; train the scene first")
    content: dict[str, Any] = torch.load(path, weights_only=True)
    if content.get("version") != FILE_VERSION:
        raise InputError(
            f"{path}: model file version {content.get('version')}, but this r3gw reads "
            f"version {FILE_VERSION}; train the scene again"
        )
    model = model_from(content)
    model.appearance.eval()
    return model


def model_from(content: dict[str, Any]) -> SceneModel:
    """Invert `model_content`."""
    settings = TrainSettings.model_validate(content["settings"])
    photos = tuple(content["photos"])
    foreground = Rows("foreground.", _values(content["foreground"]))
    sky_state = content["sky"]
    dome = SkyDome(sky_state["centre"], float(sky_state["radius"]), (0.0, 0.0))
    sky = Sky(dome, sky_state["rows.values.angles"], 0.5)
    sky.load_state_dict(sky_state)
    sessions = tuple(content["sessions"])
    appearance = _appearance(sessions, settings, torch.Generator())
    appearance.load_state_dict(content["appearance"])
    return SceneModel(foreground, sky, appearance, photos, sessions, settings)


def _values(state: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    return {name.removeprefix("values."): value for name, value in state.items()}
