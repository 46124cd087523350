"""What a picture needs of a trained scene, with everything that no frame changes computed once."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError
from r3gw.geometry.rotations import shortest_axes
from r3gw.model.lights import photo_light
from r3gw.model.model import SceneModel
from r3gw.model.rows import OCCLUSION

Light = Float[Tensor, "coeff 3"]
SkyLight = Float[Tensor, "skycoeff 3"]


@dataclass(frozen=True)
class Relightable:
    """A relightable scene; of its N Gaussians the first F are foreground, the others sky.

    Attributes:
        means: ``[N, 3]`` world.
        quaternions: ``[N, 4]`` wxyz, any length > 0.
        log_scales: ``[N, 3]`` of standard deviations in world units.
        opacity_logits: ``[N]``.
        albedo: ``[F, 3]`` linear, in [0, 1].
        roughness: ``[F]`` in [0, 1].
        lights: Per training photo its SH light and its sky coefficients.
        light_degree: SH degree of lights.
        with_specular: Whether the scene reflects.
        occlusion: What shadows take from the irradiance of each foreground Gaussian, as SH
            transfer; None where the scene models none (r3gw.model.occlusion).
    """

    means: Float[Tensor, "n 3"]
    quaternions: Float[Tensor, "n 4"]
    log_scales: Float[Tensor, "n 3"]
    opacity_logits: Float[Tensor, "n"]
    albedo: Float[Tensor, "f 3"]
    roughness: Float[Tensor, "f"]
    lights: Mapping[str, tuple[Light, SkyLight]]
    light_degree: int
    with_specular: bool
    occlusion: Float[Tensor, "f transfer"] | None = None

    @property
    def num_foreground(self) -> int:
        """F."""
        return len(self.albedo)

    @property
    def num_sky(self) -> int:
        """N - F."""
        return len(self.means) - len(self.albedo)

    @cached_property
    def scales(self) -> Float[Tensor, "n 3"]:
        """Standard deviations, world units."""
        return self.log_scales.exp()

    @cached_property
    def opacities(self) -> Float[Tensor, "n"]:
        """In [0, 1]."""
        return self.opacity_logits.sigmoid()

    @cached_property
    def normals(self) -> Float[Tensor, "f 3"]:
        """Unit normals of the foreground; the sign is arbitrary."""
        count = self.num_foreground
        return shortest_axes(self.quaternions[:count], self.log_scales[:count])

    def light_of(self, photo: str, origin: Path) -> tuple[Light, SkyLight]:
        """Light and sky coefficients learned for a photo.

        Raises:
            InputError: If there are none; the message names ``origin``, the scene's file.
        """
        if not self.lights:
            raise InputError(
                f"{origin}: no learned lights; put the export's lights.json beside the file"
            )
        if photo not in self.lights:
            known = ", ".join(self.lights)
            raise InputError(f"{origin}: has no light of a photo '{photo}'; it has: {known}")
        return self.lights[photo]


@torch.no_grad()
def relightable_of(model: SceneModel) -> Relightable:
    """Take a trained model apart into what pictures need."""
    foreground, sky = model.foreground, model.sky
    return Relightable(
        torch.cat([foreground["means"], sky.means()]),
        torch.cat([foreground["quaternions"], sky.rows["quaternions"]]),
        torch.cat([foreground["log_scales"], sky.rows["log_scales"]]),
        torch.cat([foreground["opacity_logits"], sky.rows["opacity_logits"]]),
        foreground["albedo_logits"].sigmoid(),
        foreground["roughness_logits"].sigmoid(),
        {photo: photo_light(model, photo) for photo in model.photos},
        model.description.light_degree,
        model.description.specular,
        foreground.values.get(OCCLUSION),
    )
