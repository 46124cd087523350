"""Ground truth of a view as pictures, drawn as the evaluation draws what was learned."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.evaluation.pictures import bytes_from_display, depth_picture, normal_picture
from r3gw.imaging.colour import display_array_from_linear
from r3gw.imaging.files import read_linear
from r3gw.scene import GroundTruth


def truth_pictures(truth: GroundTruth, folder: Path) -> dict[str, NDArray[np.uint8]]:
    """Pictures ``[H, W, 3]`` by kind: albedo (white at the sky), normal, depth.

    Raises:
        InputError: If a file is missing or unreadable.
    """
    albedo, normal = read_linear(folder / truth.albedo), read_linear(folder / truth.normal)
    is_surface = np.linalg.norm(normal, axis=-1, keepdims=True) > 0.5
    shown = np.where(is_surface, display_array_from_linear(albedo), 1.0)
    return {
        "albedo": bytes_from_display(shown),
        "normal": normal_picture(normal),
        "depth": depth_picture(read_linear(folder / truth.depth)[..., 0]),
    }
