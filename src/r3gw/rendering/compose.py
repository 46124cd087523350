"""One rendering pass over both sets of Gaussians (Sec. 4.1 to 4.3).

Feature channels, in this order: display colour (3), camera depth (1), foreground normal (3),
foreground-only and sky-only channel sum (1 each). The last two carry no colour gradient; where a
silhouette takes the place of Eq. 15 they hold its marks (`silhouette_marks`).
"""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.model.model import SceneModel
from r3gw.raster import rasterize
from r3gw.rendering.splats import Splats, splats_of

COLOUR, DEPTH, NORMAL, FOREGROUND, SKY = slice(0, 3), 3, slice(4, 7), 7, 8
NUM_COLOUR_GRADIENTS = 7
SMALLEST_ALPHA = 1e-6


@dataclass(frozen=True)
class Rendering:
    """What one pass returns; N counts foreground Gaussians first, then the sky's.

    Attributes:
        planes: Composited channels on black; the pictures below are views of them.
        alpha: Accumulated opacity of both sets.
        radii_px: 0 = not visible.
        means2d: Pixels; its ``.grad`` feeds densification.
        splats: What was drawn.
    """

    planes: Float[Tensor, "9 h w"]
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
    def foreground(self) -> Float[Tensor, "h w"]:
        """Channel sum of the foreground's colour, or the first mark of a silhouette."""
        return self.planes[FOREGROUND]

    @property
    def sky(self) -> Float[Tensor, "h w"]:
        """Channel sum of the sky's colour, or the second mark."""
        return self.planes[SKY]


def render(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "4 3"] | None,
) -> Rendering:
    """Render the scene.

    Args:
        model: The scene.
        camera: Where from.
        light: SH environment light, linear.
        sky_light: Sky coefficients (Eq. 11); None paints the sky white, as the protocol of
            test views does.
    """
    return draw(splats_of(model, camera, light, sky_light), camera)


def silhouette_marks(model: SceneModel, solid: float) -> Float[Tensor, "n 2"]:
    """Channel sums of which Eq. 15's mean over pixels and channels makes the silhouette loss.

    On sky pixels it counts the foreground's opacity, elsewhere ``-solid`` times that; so it is
    `r3gw.training.losses.separation.silhouette_loss` less a number that depends on the masks alone.
    """
    marks = torch.zeros(model.num_gaussians, 2)
    marks[: len(model.foreground)] = torch.tensor([3.0, -3.0 * solid])
    return marks


def draw(splats: Splats, camera: Camera) -> Rendering:
    """Composite Gaussians with everything that the losses need."""
    result = rasterize(
        splats.means,
        splats.quaternions,
        splats.scales,
        splats.opacities,
        splats.features,
        camera.cam_from_world.float(),
        camera.intrinsics,
        camera.width,
        camera.height,
        num_feature_gradients=NUM_COLOUR_GRADIENTS,
    )
    return Rendering(result.planes, result.alpha, result.radii_px, result.means2d, splats)
