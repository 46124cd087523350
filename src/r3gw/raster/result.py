"""What a rasterization returns, from the C++ kernels and from the reference alike."""

from dataclasses import dataclass

from jaxtyping import Float
from torch import Tensor


@dataclass(frozen=True)
class RasterResult:
    """One composited image and where its Gaussians landed.

    Attributes:
        planes: Composited feature channels, background included.
        alpha: Accumulated alpha, 1 − final transmittance.
        radii_px: Larger half side, in pixels, of the box in which a Gaussian's alpha can reach
            1/255; 0 where the Gaussian is not visible. No gradient.
        means2d: Projected means in pixels, (0, 0) where not visible. If any input that moves them
            requires a gradient, ``means2d.grad`` holds the gradient in pixels after backward.
    """

    planes: Float[Tensor, "channels height width"]
    alpha: Float[Tensor, "height width"]
    radii_px: Float[Tensor, " n"]
    means2d: Float[Tensor, "n 2"]

    @property
    def features(self) -> Float[Tensor, "height width channels"]:
        """The planes as a picture."""
        return self.planes.permute(1, 2, 0)
