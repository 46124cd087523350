"""One rendering pass over both sets of Gaussians: colours, depth, normals, each set by itself.

A sun's shadows fall on Gaussians before they are composited.
"""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import pad

from r3gw.geometry.cameras import Camera
from r3gw.lighting.sh import degree_of
from r3gw.lighting.sun import PointSun
from r3gw.model.model import SceneModel
from r3gw.model.rows import OCCLUSION
from r3gw.raster import rasterize
from r3gw.rendering.channels import (
    COLOUR,
    DEPTH,
    FOREGROUND,
    NORMAL,
    NUM_LEARNED,
    Layers,
)
from r3gw.rendering.splat_set import Splats, irradiance_beside
from r3gw.rendering.splats import splats_of
from r3gw.rendering.sun_shadow import reach_in, shadow_in
from r3gw.rendering.sunlight import bounced_irradiance, direct_irradiance

SMALLEST_ALPHA = 1e-6


@dataclass(frozen=True)
class Rendering:
    """What one pass returns; N counts foreground Gaussians first, then the sky's.

    Attributes:
        planes: Composited channels (`r3gw.rendering.channels`) on black; the pictures below are
            views of them.
        alpha: Accumulated opacity of both sets.
        radii_px: 0 = not visible.
        means2d: Pixels; its ``.grad`` feeds densification.
        pulls2d: Whose ``.grad`` does in its place (`r3gw.raster.rasterize`); None where not wanted.
        splats: What was drawn.
    """

    planes: Float[Tensor, "channels h w"]
    alpha: Float[Tensor, "h w"]
    radii_px: Float[Tensor, "n"]
    means2d: Float[Tensor, "n 2"]
    pulls2d: Float[Tensor, "n 2"] | None
    splats: Splats

    @property
    def colour(self) -> Float[Tensor, "h w 3"]:
        """Display values."""
        return self.planes[COLOUR].permute(1, 2, 0)

    @property
    def depth(self) -> Float[Tensor, "h w"]:
        """Expected camera z, divided by alpha."""
        return self.planes[DEPTH] / self.alpha.clamp_min(SMALLEST_ALPHA)

    @property
    def normal(self) -> Float[Tensor, "h w 3"]:
        """Composited foreground normals, world axes, not normalised."""
        return self.planes[NORMAL].permute(1, 2, 0)

    @property
    def foreground_opacity(self) -> Float[Tensor, "h w"]:
        """Opacity that the foreground contributes.

        Raises:
            ValueError: If the pass was not drawn with `Layers.OPACITY`.
        """
        if self.splats.layers is not Layers.OPACITY:
            raise ValueError(f"the pass was drawn with {self.splats.layers!r}: opacity is unknown")
        return self.planes[FOREGROUND]


@dataclass(frozen=True, eq=False)
class Sunlight:
    """A sun, and what stands in it in one camera's picture.

    Attributes:
        sun: The sun; the light that it goes with holds it, too.
        reached: Share of it that reaches each Gaussian of the foreground; None where nothing
            stands in its way.
    """

    sun: PointSun
    reached: Float[Tensor, "f"] | None


def sunlight_of(model: SceneModel, camera: Camera, sun: PointSun | None) -> Sunlight | None:
    """A light's sun with its shadows; None where the model shades by SH alone, or it has none."""
    if sun is None or not model.description.has_point_sun:
        return None
    reached = reach_in(model, camera, shadow_in(model, sun.direction))
    return Sunlight(sun.times(model.description.sharp), reached)


def render(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "4 3"] | None,
    layers: Layers = Layers.COLOUR,
    sunlight: Sunlight | None = None,
) -> Rendering:
    """Render the scene.

    Args:
        model: The scene.
        camera: Where from.
        light: SH environment light, linear; all of it.
        sky_light: Sky coefficients (Eq. 11); None paints the sky white, as the protocol of
            test views does.
        layers: What the two sets' own channels hold.
        sunlight: The part of the light that is shaded as a sun; None shades all of it by SH.
    """
    return draw(shaded_splats(model, camera, light, sky_light, layers, sunlight), camera)


def shaded_splats(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "4 3"] | None,
    layers: Layers = Layers.COLOUR,
    sunlight: Sunlight | None = None,
) -> Splats:
    """All Gaussians in the colours that they show a camera, a sun's shadows included.

    Arguments are those of `render`. No gradient goes through who stands in the sun.
    """
    if sunlight is None:
        return splats_of(model, camera, light, sky_light, layers)
    sun, foreground, bounced = sunlight.sun, model.foreground, None
    rest = light - sun.sh(degree_of(len(light)))
    if OCCLUSION in foreground:
        bounced = bounced_irradiance(foreground[OCCLUSION], sun, model.description.sun_bounce)
    beside = irradiance_beside(foreground, rest, bounced)
    in_shade = splats_of(model, camera, rest, sky_light, layers, beside)
    normals = in_shade.features[: len(foreground), NORMAL]
    direct = direct_irradiance(model, normals, camera, sun)
    if beside is not None:
        direct = direct + beside
    in_sun = splats_of(model, camera, rest, sky_light, layers, direct)
    if sunlight.reached is None:
        return in_sun
    # The sky has the same colours in both.
    reached = pad(sunlight.reached, (0, len(in_sun.means) - len(foreground)))
    return in_sun.with_colours(torch.lerp(in_shade.colours, in_sun.colours, reached[:, None]))


def draw(splats: Splats, camera: Camera, pulls2d: Float[Tensor, "n 2"] | None = None) -> Rendering:
    """Composite Gaussians with everything that the losses need; pulls as of `rasterize`."""
    result = rasterize(
        splats.means,
        splats.quaternions,
        splats.scales,
        splats.opacities,
        splats.features,
        camera.cam_from_world.to(splats.means),
        camera.intrinsics,
        camera.width,
        camera.height,
        num_feature_gradients=NUM_LEARNED,
        pulls2d=pulls2d,
    )
    return Rendering(result.planes, result.alpha, result.radii_px, result.means2d, pulls2d, splats)
