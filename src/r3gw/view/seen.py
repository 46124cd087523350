"""Which photos see each Gaussian of a page, as the bits of a texture (web/src/shading.ts)."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from r3gw.geometry.cameras import Camera
from r3gw.relight.gaussians import Relightable
from r3gw.relight.seen import MOST_ASKED
from r3gw.relight.visibility import is_seen
from r3gw.scene.selection import evenly
from r3gw.view.buffers import TEXTURE_WIDTH


def seen_bits(
    gaussians: Relightable, cameras: Sequence[Camera], rows: int
) -> tuple[list[int], NDArray[np.uint32]]:
    """The photos that are asked, and per Gaussian bit i for whether the i-th of them sees it.

    Args:
        gaussians: What the page shows.
        cameras: Cameras of the training photos, the first of the page's photos.
        rows: Rows of the page's textures.

    Returns:
        Indices of at most `MOST_ASKED` photos, and little-endian ``[rows * 2048]``.
    """
    chosen = evenly(range(len(cameras)), MOST_ASKED)
    count = gaussians.num_foreground
    bits = np.zeros(rows * TEXTURE_WIDTH, "<u4")
    for bit, number in enumerate(chosen if count else ()):
        seen = is_seen(gaussians, cameras[number], gaussians.means[:count]).numpy()
        bits[:count] |= seen.astype(np.uint32) << np.uint32(bit)
    return list(chosen), bits
