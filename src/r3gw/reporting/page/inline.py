"""Pictures and plots as data URIs, so that a page needs no other file."""

from base64 import b64encode
from io import BytesIO

import cv2
import numpy as np
from jaxtyping import Bool
from matplotlib.figure import Figure
from numpy.typing import NDArray

WEBP_QUALITY = 82
LOSSLESS = 101  # OpenCV's way to ask for it
FIGURE_DPI = 160
SKY_TINT = (0, 114, 178, 150)  # RGBA
INVALID_TINT = (230, 0, 126, 190)


def picture_uri(picture: NDArray[np.uint8], width_px: int) -> str:
    """A picture ``[H, W, 3]``, shrunk to a width if it is wider, as WebP."""
    fitted = _fitted(picture, width_px, cv2.INTER_AREA)
    return _webp(cv2.cvtColor(fitted, cv2.COLOR_RGB2BGR), WEBP_QUALITY)


def mask_uri(
    is_valid: Bool[np.ndarray, "h w"], is_sky: Bool[np.ndarray, "h w"], width_px: int
) -> str:
    """Masks as a tint to lay over the photo: sky blue, what is not valid magenta."""
    tint = np.zeros((*is_sky.shape, 4), np.uint8)
    tint[is_sky] = SKY_TINT
    tint[~is_valid] = INVALID_TINT
    fitted = _fitted(tint, width_px, cv2.INTER_NEAREST)
    return _webp(cv2.cvtColor(fitted, cv2.COLOR_RGBA2BGRA), LOSSLESS)


def figure_uri(figure: Figure) -> str:
    """A figure that holds many points, as WebP."""
    with BytesIO() as stream:
        figure.savefig(stream, dpi=FIGURE_DPI, format="png")
        encoded = np.frombuffer(stream.getvalue(), np.uint8)
    pixels = np.asarray(cv2.imdecode(encoded, cv2.IMREAD_COLOR), np.uint8)
    return _webp(pixels, WEBP_QUALITY)


def plot_uri(figure: Figure) -> str:
    """A plot as SVG; no dates inside."""
    with BytesIO() as stream:
        figure.savefig(stream, format="svg", metadata={"Date": None})
        return "data:image/svg+xml;base64," + b64encode(stream.getvalue()).decode()


def _fitted(picture: NDArray[np.uint8], width_px: int, interpolation: int) -> NDArray[np.uint8]:
    height, width = picture.shape[:2]
    if width <= width_px:
        return picture
    size = (width_px, round(height * width_px / width))
    return np.asarray(cv2.resize(picture, size, interpolation=interpolation), np.uint8)


def _webp(pixels: cv2.typing.MatLike, quality: int) -> str:
    done, encoded = cv2.imencode(".webp", pixels, [cv2.IMWRITE_WEBP_QUALITY, quality])
    if not done:
        raise OSError("could not encode a picture as WebP")
    return "data:image/webp;base64," + b64encode(encoded.tobytes()).decode()
