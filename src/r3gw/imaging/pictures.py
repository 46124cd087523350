"""From float buffers to 8-bit pictures: colour, normals, depth."""

import cv2
import numpy as np
import torch
from jaxtyping import Float
from numpy.typing import NDArray
from torch import Tensor

NEAR_FAR_QUANTILES = (0.02, 0.98)


def bytes_from_display(
    display: Float[Tensor, "h w 3"] | Float[np.ndarray, "h w 3"],
) -> NDArray[np.uint8]:
    """Round display values, clamped to [0, 1], to 8 bits."""
    values = display.numpy() if isinstance(display, torch.Tensor) else display
    return np.asarray(np.rint(np.clip(values, 0.0, 1.0) * 255.0), dtype=np.uint8)


def normal_picture(normals: Float[np.ndarray, "h w 3"]) -> NDArray[np.uint8]:
    """World normals as colour: right (+x) red, up (-y) green, towards -z blue; zero is grey."""
    return bytes_from_display(0.5 + 0.5 * normals * np.array([1.0, -1.0, -1.0]))


def depth_picture(depth: Float[np.ndarray, "h w"]) -> NDArray[np.uint8]:
    """Depth on viridis from its 2nd to its 98th percentile; 0 (nothing) is black."""
    is_known = depth > 0
    if not is_known.any():
        return np.zeros((*depth.shape, 3), np.uint8)
    near, far = np.quantile(depth[is_known], NEAR_FAR_QUANTILES)
    share = np.clip((depth - near) / max(far - near, 1e-9), 0.0, 1.0)
    levels = np.rint(share * 255.0).astype(np.uint8)
    coloured = cv2.applyColorMap(levels, cv2.COLORMAP_VIRIDIS)[..., ::-1].copy()
    coloured[~is_known] = 0
    return np.asarray(coloured, dtype=np.uint8)
