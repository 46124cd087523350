"""The whole learned scene."""

from dataclasses import dataclass

from r3gw.model.appearance import Appearance
from r3gw.model.description import ModelDescription
from r3gw.model.rows import Rows
from r3gw.model.sky import Sky


@dataclass
class SceneModel:
    """A relightable scene.

    Attributes:
        description: What it is.
        foreground: Rows ``means, log_scales, quaternions, opacity_logits, albedo_logits,
            roughness_logits``, and ``occlusion`` where the scene shades itself.
        sky: Sky Gaussians; empty for a single-set model.
        appearance: Light and sky colour per training photo.
        photos: Names of the training photos, in the order of the embedding.
        sessions: The photos' sessions, in the same order.
    """

    description: ModelDescription
    foreground: Rows
    sky: Sky
    appearance: Appearance
    photos: tuple[str, ...]
    sessions: tuple[str, ...]

    @property
    def num_gaussians(self) -> int:
        """Foreground and sky together."""
        return len(self.foreground) + len(self.sky.rows)
