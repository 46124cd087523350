"""Taking back what Gaussians do where no photo looks (beyond the paper).

A photo does not mind a Gaussian behind it, beside it, or as large as the scene before its lens, and
other views are full of it. Two bounds hold that back: nothing is nearer to a camera than a share of
what cameras usually look at, and nothing looks larger than a given angle from the nearest camera.
"""

from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor
from torch.optim import Optimizer

from r3gw.model.attributes import LOG_SCALES
from r3gw.model.model import SceneModel
from r3gw.training.settings import UnseenSettings

SMALLEST_SCALE = 1e-6  # world units; of what lies in a camera


@torch.no_grad()
def hold_back_unseen(
    model: SceneModel,
    optimizer: Optimizer,
    centres: Sequence[Float[Tensor, "3"]],
    settings: UnseenSettings,
) -> int:
    """Take away foreground near a camera, and bound the scales of all Gaussians.

    Args:
        model: Changed in place.
        optimizer: Its state follows the rows.
        centres: Where the training photos were taken, world.
        settings: ``nearest`` and ``widest``.

    Returns:
        How many Gaussians were taken away.
    """
    rows, sky = model.foreground, model.sky
    distances = distances_to_nearest(rows["means"], centres)
    is_kept = distances >= settings.nearest * distances.median()
    if not is_kept.any():
        return 0
    none = {name: value.detach()[:0] for name, value in rows.values.items()}
    rows.rebuild(optimizer, torch.nonzero(is_kept).squeeze(-1), none)
    limits = (settings.widest * distances[is_kept]).clamp_min(SMALLEST_SCALE).log()
    rows[LOG_SCALES.name].clamp_(max=limits[:, None])
    sky.rows[LOG_SCALES.name].clamp_(max=float((settings.widest * sky.radius).log()))
    return int((~is_kept).sum())


def distances_to_nearest(
    means: Float[Tensor, "n 3"], centres: Sequence[Float[Tensor, "3"]]
) -> Float[Tensor, "n"]:
    """From each position to the camera that is nearest to it, world units."""
    nearest = means.new_full((len(means),), torch.inf)
    for centre in centres:
        nearest = torch.minimum(nearest, (means - centre.to(means)).norm(dim=-1))
    return nearest
