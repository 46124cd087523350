"""Per-Gaussian parameters that grow and shrink together, optimizer state included."""

from collections.abc import Mapping

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.optim import Optimizer

# Follows the rows but is computed, not learned (r3gw.model.occlusion); optional.
OCCLUSION = "occlusion"


class Rows(nn.Module):
    """Named parameters with one row per Gaussian.

    The optimizer must hold each parameter that is learned in a group of its own, whose ``"name"``
    is the parameter's name with ``prefix`` before it.
    """

    def __init__(self, prefix: str, values: Mapping[str, Float[Tensor, "n ..."]]) -> None:
        """Take ``values`` as the parameters' first rows."""
        super().__init__()
        self.prefix = prefix
        self.values = nn.ParameterDict(
            {name: nn.Parameter(v, requires_grad=name != OCCLUSION) for name, v in values.items()}
        )

    def __getitem__(self, name: str) -> Tensor:
        """The parameter ``name``, all rows."""
        parameter: Tensor = self.values[name]
        return parameter

    def add_computed(self, name: str, value: Float[Tensor, "n ..."]) -> None:
        """Let ``value`` follow the rows without being learned."""
        self.values[name] = nn.Parameter(value, requires_grad=False)

    def __contains__(self, name: str) -> bool:
        """Whether the rows have a parameter ``name``."""
        return name in self.values

    def __len__(self) -> int:
        """Number of Gaussians."""
        return int(next(iter(self.values.values())).shape[0])

    def rebuild(
        self, optimizer: Optimizer, kept: Int[Tensor, "k"], added: Mapping[str, Tensor]
    ) -> None:
        """Keep the rows ``kept``, in that order, then append ``added``.

        Kept rows keep their optimizer state; added rows start with zero moments.
        """
        for name in list(self.values):
            grown = torch.cat([self.values[name].detach()[kept], added[name].detach()])
            self._replace(optimizer, name, grown, kept)

    def overwrite(self, optimizer: Optimizer, name: str, value: Tensor) -> None:
        """Set all rows of one parameter and forget its moments (opacity reset)."""
        none = torch.zeros(0, dtype=torch.long)
        self._replace(optimizer, name, value.detach().clone(), none)

    def _replace(
        self, optimizer: Optimizer, name: str, value: Tensor, kept: Int[Tensor, "k"]
    ) -> None:
        old = self.values[name]
        new = nn.Parameter(value, requires_grad=old.requires_grad)
        self.values[name] = new
        if not new.requires_grad:
            return
        wanted = f"{self.prefix}{name}"
        group = next(g for g in optimizer.param_groups if g["name"] == wanted)
        group["params"] = [new]
        state = optimizer.state.pop(old, None)
        if not state:
            return
        for key in ("exp_avg", "exp_avg_sq"):
            moments = torch.zeros_like(new)
            moments[: len(kept)] = state[key][kept]
            state[key] = moments
        optimizer.state[new] = state
