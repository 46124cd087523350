"""What every light model answers: which light falls on the scene in a photo.

A light model is a module: its parameters are what it learns beyond the appearance MLP, its buffers
what it keeps. How it is started and trained is said in `r3gw.training.lights`.
"""

from abc import ABC, abstractmethod
from typing import Literal, NamedTuple

from jaxtyping import Float
from torch import Tensor, nn

from r3gw.files.strict import Strict
from r3gw.lighting.sun import PointSun

LightDegree = Literal[2, 4]  # What the shading kernels are compiled for.


class OpenSky(NamedTuple):
    """A photo's sky above the horizon.

    Attributes:
        radiance: SH coefficients, linear.
        change: Their part that is learned.
    """

    radiance: Float[Tensor, "4 3"]
    change: Float[Tensor, "4 3"]

    def times(self, gains: Float[Tensor, "3"]) -> "OpenSky":
        """The sky as a camera of such gains shows it; what was learned of it stays as it is."""
        return self._replace(radiance=self.radiance * gains)


class DaySky(NamedTuple):
    """A photo's sky above the horizon as the CIE's skies have it, and a learned change.

    Attributes:
        colours: Of the parts of a sky (`r3gw.lighting.cie_sky.PARTS`), linear.
        sun: Unit vector to where the clear sky's sun stands.
        change: SH coefficients, linear; learned.
    """

    colours: Float[Tensor, "parts 3"]
    sun: Float[Tensor, "3"]
    change: Float[Tensor, "4 3"]

    def times(self, gains: Float[Tensor, "3"]) -> "DaySky":
        """The sky as a camera of such gains shows it."""
        return self._replace(colours=self.colours * gains, change=self.change * gains)


class Environment(NamedTuple):
    """The light of one photo. What a light model knows beyond its SH is a field with a default.

    Attributes:
        light: SH environment light, linear; all of it.
        open_sky: What lies above the horizon, where that is modelled on its own.
        sun: The sun, where surfaces are shaded with it and not with its SH.
    """

    light: Float[Tensor, "coeff 3"]
    open_sky: OpenSky | DaySky | None = None
    sun: PointSun | None = None


class LightModel(nn.Module, ABC):
    """From a photo's output of the appearance MLP to its light.

    Attributes:
        first: ``[k, 3]`` SH coefficients that the MLP gives before anything is learned; k says how
            many it gives.
    """

    first: Tensor

    def __init__(self, first: Float[Tensor, "k 3"]) -> None:
        """Let the MLP start from ``first``."""
        super().__init__()
        self.register_buffer("first", first, persistent=False)

    @abstractmethod
    def describe(self) -> "LightModelDescription":
        """What a file must say of it."""

    @abstractmethod
    def environment(
        self,
        photo: int,
        row: int,
        learned: Float[Tensor, "k 3"],
        exposure: Float[Tensor, ""] | None,
    ) -> Environment:
        """The light of a training photo.

        Args:
            photo: Which photo.
            row: Which embedding it uses: its session where light is shared.
            learned: What the MLP gives for that embedding.
            exposure: The photo's factor on the light; None where each photo has its own light.
        """


class LightModelDescription(Strict, ABC):
    """What a model file says of its light model.

    Attributes:
        degree: SH degree of the light.
    """

    degree: LightDegree

    @abstractmethod
    def build(self, num_photos: int, num_rows: int) -> LightModel:
        """The light model with arrays of the right shapes, to be filled from a file."""
