"""Per-photo light and sky colour: an embedding and an MLP (paper, Eq. 3 and appendix)."""

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn

from r3gw.lighting import outdoor, sh
from r3gw.model.outdoor import OpenSky, OutdoorLight
from r3gw.model.settings import ModelSettings
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
    """

    light: Float[Tensor, "coeff 3"]
    sky_light: Float[Tensor, "4 3"]
    open_sky: OpenSky | None


class Appearance(nn.Module):
    """Maps a training photo's index to its environment light and its sky coefficients.

    Photos of one session can share an embedding; then each has an exposure of its own, a factor
    on the light.
    """

    def __init__(
        self,
        rows: Sequence[int],
        settings: ModelSettings,
        first_light: Float[Tensor, "coeff 3"] | OutdoorLight,
        generator: torch.Generator,
    ) -> None:
        """Start at a first light with small random variation.

        Args:
            rows: Which embedding each photo uses, from 0 on without gaps.
            settings: Sizes, noise and dropout.
            first_light: SH coefficients that all photos start from and may leave freely, or sun and
                sky, which the MLP then changes.
            generator: Draws the first weights.
        """
        super().__init__()
        self.rows = tuple(rows)
        num_rows = max(rows) + 1
        hidden = settings.hidden_size
        self.light_noise = settings.light_noise
        self.outdoor = first_light if isinstance(first_light, OutdoorLight) else None
        degree = settings.light_degree if self.outdoor is None else outdoor.SKY_DEGREE
        self.embedding = nn.Parameter(
            torch.randn(num_rows, settings.embedding_size, generator=generator)
        )
        self.log_exposure: nn.Parameter | None = None
        if num_rows < len(rows):
            self.log_exposure = nn.Parameter(torch.zeros(len(rows)))
        self._dropout = nn.Dropout(settings.dropout)
        self.trunk = nn.Sequential(
            nn.Linear(settings.embedding_size, hidden),
            nn.ReLU(),
            self._dropout,
            nn.Linear(hidden, hidden),
            nn.ReLU(),
            nn.Linear(hidden, hidden),
            nn.ReLU(),
        )
        self.sky_head = nn.Linear(hidden, 3 * sh.num_coefficients(SKY_DEGREE))
        self.light_head = nn.Sequential(
            nn.Linear(hidden, settings.light_hidden_size),
            nn.ReLU(),
            nn.Linear(settings.light_hidden_size, 3 * sh.num_coefficients(degree)),
        )
        self._linear_layers = tuple(m for m in self.modules() if isinstance(m, nn.Linear))
        self._initialise(generator)
        if isinstance(first_light, Tensor):
            with torch.no_grad():
                self._linear_layers[-1].bias.copy_(first_light.reshape(-1))

    @torch.no_grad()
    def _initialise(self, generator: torch.Generator) -> None:
        for layer in self._linear_layers:
            nn.init.kaiming_uniform_(layer.weight, a=sqrt(5), generator=generator)
            layer.bias.zero_()
        for head in (self._linear_layers[-1], self.sky_head):
            head.weight.mul_(FIRST_VARIATION)

    def forward(self, photo: int) -> PhotoLight:
        """What lights one training photo, without noise."""
        light, sky = self._coefficients(self.rows[photo])
        exposure = 1.0 if self.log_exposure is None else self.log_exposure[photo].exp()
        if self.outdoor is not None:
            light, open_sky = self.outdoor(self.rows[photo], light, exposure)
            return PhotoLight(light, sky, open_sky)
        return PhotoLight(light if self.log_exposure is None else light * exposure, sky, None)

    def _coefficients(self, row: int) -> tuple[Float[Tensor, "coeff 3"], Float[Tensor, "4 3"]]:
        """What the MLP makes of a row of the embedding: light and sky, by a kernel or plainly."""
        layers, dropout, factors = self._linear_layers, self._dropout, None
        if not kernels.take("appearance", self.embedding):
            features = self.trunk(self.embedding[row])
            light, sky = self.light_head(features), self.sky_head(features)
            return light.view(-1, 3), sky.view(-1, 3)
        if self.training and dropout.p > 0:
            factors = dropout(torch.ones_like(layers[0].bias))
        weights, biases = [layer.weight for layer in layers], [layer.bias for layer in layers]
        return ops.appearance(self.embedding, row, factors, weights, biases)

    def noisy(
        self, light: Float[Tensor, "coeff 3"], generator: torch.Generator
    ) -> Float[Tensor, "coeff 3"]:
        """Add the training noise to light coefficients."""
        noise = torch.randn(light.shape, generator=generator)
        return torch.add(light, noise.to(light), alpha=self.light_noise)
