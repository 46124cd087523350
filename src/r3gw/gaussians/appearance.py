"""Per-photo light and sky colour: an embedding and an MLP (paper, Eq. 3 and appendix)."""

from collections.abc import Sequence
from math import isqrt, pi, sqrt

import torch
from jaxtyping import Float
from torch import Tensor, nn

import r3gw._C  # noqa: F401  Registers torch.ops.r3gw.
from r3gw.gaussians.sky import SKY_DEGREE
from r3gw.lighting import sh
from r3gw.settings.train import InitSettings, ModelSettings

# Factor on the last layers' first weights: all photos start with nearly the same, uniform light.
FIRST_VARIATION = 0.1


def first_light(init: InitSettings, degree: int) -> Float[Tensor, "coeff"]:
    """SH coefficients of an even sky over even ground, as far as bands 0 and 1 show them.

    The mean radiance is ``light_radiance``, the ground has ``light_below`` times the sky's.
    """
    light = torch.zeros(sh.num_coefficients(degree))
    light[0] = init.light_radiance * sqrt(4 * pi)
    # Half the step at the horizon, times the integral of |cos| over the sphere; up is -y.
    step = init.light_radiance * (1 - init.light_below) / (1 + init.light_below)
    light[1] = -step * 2 * pi * sqrt(3 / (4 * pi))
    return light


class Appearance(nn.Module):
    """Maps a training photo's index to its environment light and its sky coefficients.

    Photos of one session can share an embedding; then each has an exposure of its own, a factor
    on the light.
    """

    def __init__(
        self,
        rows: Sequence[int],
        settings: ModelSettings,
        init: InitSettings,
        generator: torch.Generator,
    ) -> None:
        """Start at the light of `first_light` with small random variation.

        Args:
            rows: Which embedding each photo uses, from 0 on without gaps.
            settings: Sizes, noise and dropout.
            init: The first light.
            generator: Draws the first weights.
        """
        super().__init__()
        self.rows = tuple(rows)
        num_rows = max(rows) + 1
        hidden = settings.hidden_size
        self.light_noise = settings.light_noise
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
            nn.Linear(settings.light_hidden_size, 3 * sh.num_coefficients(settings.light_degree)),
        )
        self._linear_layers = tuple(m for m in self.modules() if isinstance(m, nn.Linear))
        self._initialise(init, generator)

    @torch.no_grad()
    def _initialise(self, init: InitSettings, generator: torch.Generator) -> None:
        for layer in self._linear_layers:
            nn.init.kaiming_uniform_(layer.weight, a=sqrt(5), generator=generator)
            layer.bias.zero_()
        last = self.light_head[-1]
        assert isinstance(last, nn.Linear)  # for the type checker
        degree = isqrt(len(last.bias) // 3) - 1
        last.bias.copy_(first_light(init, degree)[:, None].expand(-1, 3).reshape(-1))
        for head in (last, self.sky_head):
            head.weight.mul_(FIRST_VARIATION)

    def forward(self, photo: int) -> tuple[Float[Tensor, "coeff 3"], Float[Tensor, "4 3"]]:
        """Light ``[(degree+1)**2, 3]`` and sky ``[4, 3]`` of one training photo, without noise."""
        layers, dropout, factors = self._linear_layers, self._dropout, None
        if self.training and dropout.p > 0:
            factors = dropout(torch.ones_like(layers[0].bias))
        light: Tensor
        light, sky = torch.ops.r3gw.appearance(
            self.embedding,
            self.rows[photo],
            factors,
            [layer.weight for layer in layers],
            [layer.bias for layer in layers],
        )
        if self.log_exposure is not None:
            light = light * self.log_exposure[photo].exp()
        return light, sky

    def noisy(
        self, light: Float[Tensor, "coeff 3"], generator: torch.Generator
    ) -> Float[Tensor, "coeff 3"]:
        """Add the training noise to light coefficients."""
        noise = torch.randn(light.shape, generator=generator)
        return torch.add(light, noise, alpha=self.light_noise)
