"""Per-photo light and sky colour: an embedding and an MLP (paper, Eq. 3 and appendix)."""

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn

from r3gw.lighting import sh
from r3gw.lighting.gains import sky_with_gains
from r3gw.lighting.sun import PointSun
from r3gw.model.description import ModelDescription
from r3gw.model.light_models.base import DaySky, LightModel, OpenSky
from r3gw.model.sky import SKY_DEGREE
from r3gw.native import kernels, ops

# Factor on the last layers' first weights: all photos start with nearly the same, uniform light.
FIRST_VARIATION = 0.1


class PhotoLight(NamedTuple):
    """What lights one photo.

    Attributes:
        light: SH environment light, linear.
        sky_light: Coefficients of the sky's colour (Eq. 11).
        open_sky: What lies above the horizon, where that is modelled on its own.
        sun: The sun, where surfaces are shaded with it and not with its SH.
    """

    light: Float[Tensor, "coeff 3"]
    sky_light: Float[Tensor, "4 3"]
    open_sky: OpenSky | DaySky | None
    sun: PointSun | None = None


class Appearance(nn.Module):
    """Maps a training photo's index to its environment light and its sky coefficients.

    Photos of one session can share an embedding; then each has an exposure of its own, a factor
    on the light. With gains, each photo has an exposure and a white balance of its own instead,
    three factors that belong to its camera and not to the light.

    Attributes:
        light_model: Makes the light of what the MLP gives.
        dropout: Of the MLP's first layer while training; its share ``p`` is training's to set.
    """

    def __init__(
        self,
        rows: Sequence[int],
        description: ModelDescription,
        light_model: LightModel,
        generator: torch.Generator,
    ) -> None:
        """Start at the light model's first light with small random variation.

        Args:
            rows: Which embedding each photo uses, from 0 on without gaps.
            description: Layer sizes.
            light_model: What the MLP's light becomes.
            generator: Draws the first weights.
        """
        super().__init__()
        self.rows = tuple(rows)
        num_rows = max(rows) + 1
        embedding_size, hidden = description.embedding_size, description.hidden_size
        self.light_model = light_model
        self.dropout = nn.Dropout(0.0)
        self.embedding = nn.Parameter(torch.randn(num_rows, embedding_size, generator=generator))
        self.log_exposure: nn.Parameter | None = None
        self.log_gains: nn.Parameter | None = None
        if description.photo_gains:
            self.log_gains = nn.Parameter(torch.zeros(len(rows), 3))
        elif num_rows < len(rows):
            self.log_exposure = nn.Parameter(torch.zeros(len(rows)))
        self.trunk = nn.Sequential(
            nn.Linear(embedding_size, hidden),
            nn.ReLU(),
            self.dropout,
            nn.Linear(hidden, hidden),
            nn.ReLU(),
            nn.Linear(hidden, hidden),
            nn.ReLU(),
        )
        self.sky_head = nn.Linear(hidden, 3 * sh.num_coefficients(SKY_DEGREE))
        self.light_head = nn.Sequential(
            nn.Linear(hidden, description.light_hidden_size),
            nn.ReLU(),
            nn.Linear(description.light_hidden_size, light_model.first.numel()),
        )
        self._linear_layers = tuple(m for m in self.modules() if isinstance(m, nn.Linear))
        self._initialise(generator)

    @torch.no_grad()
    def _initialise(self, generator: torch.Generator) -> None:
        for layer in self._linear_layers:
            nn.init.kaiming_uniform_(layer.weight, a=sqrt(5), generator=generator)
            layer.bias.zero_()
        for head in (self._linear_layers[-1], self.sky_head):
            head.weight.mul_(FIRST_VARIATION)
        self._linear_layers[-1].bias.copy_(self.light_model.first.reshape(-1))

    def forward(self, photo: int) -> PhotoLight:
        """What lights one training photo as its camera shows it, without noise."""
        lit = self.scene_light(photo)
        if self.log_gains is None:
            return lit
        gains = self.gains()[photo]
        open_sky = None if lit.open_sky is None else lit.open_sky.times(gains)
        sun = None if lit.sun is None else lit.sun.times(gains)
        return PhotoLight(lit.light * gains, sky_with_gains(lit.sky_light, gains), open_sky, sun)

    def gains(self) -> Float[Tensor, "photos 3"]:
        """Exposure times white balance of every photo; their median over photos is 1.

        So they never take what is the scene's: its colour, or how bright it is. A mean would let
        one photo taken at night change how bright all others are.
        """
        if self.log_gains is None:
            return self.embedding.new_ones(len(self.rows), 3)
        return (self.log_gains - self.log_gains.detach().median(dim=0).values).exp()

    @torch.no_grad()
    def set_gains(self, gains: Float[Tensor, "photos 3"]) -> None:
        """Let photos begin with these gains, where they have any."""
        if self.log_gains is not None:
            self.log_gains.copy_(gains.log())

    def scene_light(self, photo: int) -> PhotoLight:
        """What lights the scene in one training photo, whatever its camera made of it."""
        row = self.rows[photo]
        learned, sky_light = self._coefficients(row)
        exposure = None if self.log_exposure is None else self.log_exposure[photo].exp()
        light, open_sky, sun = self.light_model.environment(photo, row, learned, exposure)
        return PhotoLight(light, sky_light, open_sky, sun)

    def _coefficients(self, row: int) -> tuple[Float[Tensor, "coeff 3"], Float[Tensor, "4 3"]]:
        """What the MLP gives for an embedding, by a kernel or plainly: the light, and the sky's."""
        layers, factors = self._linear_layers, None
        if not kernels.take("appearance", self.embedding):
            features = self.trunk(self.embedding[row])
            light, sky_light = self.light_head(features), self.sky_head(features)
            return light.view(-1, 3), sky_light.view(-1, 3)
        if self.training and self.dropout.p > 0:
            factors = self.dropout(torch.ones_like(layers[0].bias))
        weights, biases = [layer.weight for layer in layers], [layer.bias for layer in layers]
        return ops.appearance(self.embedding, row, factors, weights, biases)
