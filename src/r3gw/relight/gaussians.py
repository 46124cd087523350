"""What a picture needs of a trained scene, with everything that no frame changes computed once."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.geometry.rotations import shortest_axes
from r3gw.lighting.light import Light
from r3gw.model.attributes import (
    LOG_SCALES,
    MEANS,
    OPACITY,
    QUATERNIONS,
    Attribute,
    materials_of,
)
from r3gw.model.lights import learned_lights
from r3gw.model.model import SceneModel
from r3gw.model.rows import OCCLUSION
from r3gw.raster import RasterResult, rasterize
from r3gw.relight.dome import Dome, dome_through


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
        lights: What was learned for every training photo: its light, with a `LearnedSky`.
        light_degree: SH degree of lights.
        with_specular: Whether the scene reflects.
        occlusion: What shadows take from the irradiance of each foreground Gaussian, as SH
            transfer; None where the scene models none (r3gw.model.occlusion).
        has_point_sun: Whether it is shaded with a light's sun itself, where there is one.
        sun_bounce: See `r3gw.rendering.sunlight.bounced_irradiance`.
        sharp: Share of the sun that is shaded as such; the rest stays in the SH light.
        origin: Where the scene came from, for messages: a file's path.
    """

    means: Float[Tensor, "n 3"]
    quaternions: Float[Tensor, "n 4"]
    log_scales: Float[Tensor, "n 3"]
    opacity_logits: Float[Tensor, "n"]
    albedo: Float[Tensor, "f 3"]
    roughness: Float[Tensor, "f"]
    lights: Mapping[str, Light]
    light_degree: int
    with_specular: bool
    occlusion: Float[Tensor, "f transfer"] | None = None
    has_point_sun: bool = False
    sun_bounce: float = 0.0
    sharp: float = 1.0
    origin: str = "the scene"

    @property
    def num_foreground(self) -> int:
        """Number of foreground Gaussians, F."""
        return len(self.albedo)

    @property
    def num_sky(self) -> int:
        """Number of sky Gaussians, N - F."""
        return len(self.means) - len(self.albedo)

    @cached_property
    def scales(self) -> Float[Tensor, "n 3"]:
        """Standard deviations of all Gaussians, in world units."""
        return self.log_scales.exp()

    @cached_property
    def opacities(self) -> Float[Tensor, "n"]:
        """Opacities of all Gaussians, in [0, 1]."""
        return self.opacity_logits.sigmoid()

    @cached_property
    def normals(self) -> Float[Tensor, "f 3"]:
        """Unit normals of the foreground; the sign is arbitrary."""
        count = self.num_foreground
        return shortest_axes(self.quaternions[:count], self.log_scales[:count])

    @cached_property
    def middle(self) -> Float[Tensor, "3"]:
        """Median of the foreground's positions: where its surfaces are."""
        return self.means[: self.num_foreground].median(dim=0).values

    @cached_property
    def dome(self) -> Dome | None:
        """The sphere on which the sky's Gaussians hang; None without such a sphere."""
        return dome_through(self.means[self.num_foreground :])

    def drawn(self, features: Float[Tensor, "n c"], camera: Camera) -> RasterResult:
        """Composite given values of all Gaussians, foreground and sky, as a camera sees them."""
        return rasterize(
            self.means,
            self.quaternions,
            self.scales,
            self.opacities,
            features,
            camera.cam_from_world.float(),
            camera.intrinsics,
            camera.width,
            camera.height,
        )

    def light_of(self, photo: str) -> Light:
        """The light that was learned for a photo, with its sky.

        Raises:
            InputError: If there is none.
        """
        if not self.lights:
            raise InputError(
                f"{self.origin}: no learned lights; put the export's lights.json beside the file"
            )
        if photo not in self.lights:
            known = ", ".join(self.lights)
            raise InputError(f"{self.origin}: has no light of a photo '{photo}'; it has: {known}")
        return self.lights[photo]


@torch.no_grad()
def relightable_of(model: SceneModel, origin: str = "the model") -> Relightable:
    """Take a trained model apart into what pictures need; ``origin`` is for messages."""
    foreground, sky = model.foreground, model.sky

    def both(attribute: Attribute) -> Tensor:
        return torch.cat([foreground[attribute.name], sky.rows[attribute.name]])

    return Relightable(
        means=torch.cat([foreground[MEANS.name], sky.means()]),
        quaternions=both(QUATERNIONS),
        log_scales=both(LOG_SCALES),
        opacity_logits=both(OPACITY),
        **materials_of(foreground),
        lights=learned_lights(model),
        light_degree=model.description.light_degree,
        with_specular=model.description.specular,
        occlusion=foreground.values.get(OCCLUSION),
        has_point_sun=model.description.has_point_sun,
        sun_bounce=model.description.sun_bounce,
        sharp=model.description.sharp,
        origin=origin,
    )
