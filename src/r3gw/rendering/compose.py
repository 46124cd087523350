"""One rendering pass over both sets of Gaussians: colours, depth, normals, each set by itself."""

from dataclasses import dataclass

from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.model.model import SceneModel
from r3gw.raster import rasterize
from r3gw.rendering.channels import COLOUR, DEPTH, FOREGROUND, NORMAL, NUM_LEARNED, Layers
from r3gw.rendering.splat_set import Splats
from r3gw.rendering.splats import splats_of

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
        splats: What was drawn.
    """

    planes: Float[Tensor, "channels h w"]
    alpha: Float[Tensor, "h w"]
    radii_px: Float[Tensor, "n"]
    means2d: Float[Tensor, "n 2"]
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


def render(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "4 3"] | None,
    layers: Layers = Layers.COLOUR,
) -> Rendering:
    """Render the scene.

    Args:
        model: The scene.
        camera: Where from.
        light: SH environment light, linear.
        sky_light: Sky coefficients (Eq. 11); None paints the sky white, as the protocol of
            test views does.
        layers: What the two sets' own channels hold.
    """
    return draw(splats_of(model, camera, light, sky_light, layers), camera)


def draw(splats: Splats, camera: Camera) -> Rendering:
    """Composite Gaussians with everything that the losses need."""
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
    )
    return Rendering(result.planes, result.alpha, result.radii_px, result.means2d, splats)
