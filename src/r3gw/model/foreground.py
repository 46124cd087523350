"""Foreground Gaussians: geometry and material at the sparse points."""

from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.model.attributes import FOREGROUND, first_rows
from r3gw.model.rows import Rows
from r3gw.model.settings import InitSettings

PREFIX = "foreground."


def initial_foreground(xyz: Float[Tensor, "n 3"], init: InitSettings) -> Rows:
    """Gaussians at the sparse points: isotropic, random-free, of uniform material."""
    return Rows(PREFIX, first_rows(FOREGROUND, xyz, init))


def too_large(log_scales: Float[Tensor, "n 3"], limit: float) -> Bool[Tensor, "n"]:
    """True where a Gaussian's largest scale exceeds ``limit`` (world units)."""
    return log_scales.detach().exp().amax(dim=-1) > limit
