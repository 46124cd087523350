"""Ground truth of a view as pictures, drawn as the evaluation draws what was learned."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.imaging.colour import display_array_from_linear
from r3gw.imaging.files import read_linear
from r3gw.imaging.pictures import bytes_from_display, normal_picture
from r3gw.reporting.figures.style import Scale
from r3gw.scene import GroundTruth

NEAR_FAR_QUANTILES = (0.02, 0.92)  # the far background would take most of the colours


def truth_pictures(truth: GroundTruth, folder: Path) -> dict[str, NDArray[np.uint8]]:
    """Pictures ``[H, W, 3]`` by kind: albedo (white at the sky) and normal.

    Raises:
        InputError: If a file is missing or unreadable.
    """
    albedo, normal = read_linear(folder / truth.albedo), read_linear(folder / truth.normal)
    is_surface = np.linalg.norm(normal, axis=-1, keepdims=True) > 0.5
    shown = np.where(is_surface, display_array_from_linear(albedo), 1.0)
    return {
        "albedo": bytes_from_display(shown),
        "normal": normal_picture(normal),
    }


@dataclass(frozen=True)
class DepthPictures:
    """Rendered and, where known, true depth on one colour scale; ``label`` tells its ends."""

    ours: NDArray[np.uint8]
    truth: NDArray[np.uint8] | None
    label: str


def depth_pictures(
    ours: NDArray[np.floating], truth: GroundTruth | None, folder: Path
) -> DepthPictures:
    """Draw depth ``[H, W]`` beside the truth.

    Raises:
        InputError: If the truth is missing or unreadable.
    """
    true = None if truth is None else read_linear(folder / truth.depth)[..., 0]
    scale = depth_scale([ours if true is None else true])
    drawn = None if true is None else scale.coloured(true, true > 0)
    label = f"{scale.low:.1f} to {scale.high:.1f}"
    return DepthPictures(scale.coloured(ours, ours > 0), drawn, label)


def depth_scale(depths: Sequence[NDArray[np.floating]]) -> Scale:
    """One scale for several depth maps, over what is known of them (depth above 0)."""
    values = np.concatenate([depth[depth > 0] for depth in depths])
    low, high = np.quantile(values, NEAR_FAR_QUANTILES) if len(values) else (0.0, 1.0)
    return Scale("viridis", float(low), float(high), "depth (world units)")
