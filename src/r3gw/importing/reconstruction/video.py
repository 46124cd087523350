"""A video as photos: the sharpest frame of each of a number of equal stretches, by OpenCV."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.imaging.files import write_image

VIDEO_SUFFIXES = (".mp4", ".mov", ".m4v", ".avi", ".mkv", ".webm")


def extract_frames(video: Path, target: Path, count: int) -> None:
    """Write ``count`` frames of a video as ``target/frame_<number>.png``, in their order.

    The video is cut into stretches of equal length, and the frame with the strongest edges
    (variance of the Laplacian) stands for each, so that motion blur drops out. Rotation that the
    video's header asks for is applied. A video with fewer frames gives all of them.

    Raises:
        InputError: If the file is no readable video.
    """
    # The count in a header may be an estimate, so frames are counted by a first pass.
    total = sum(1 for _ in _frames(video))
    if not total:
        raise InputError(
            f"{video}: not a readable video ({', '.join(VIDEO_SUFFIXES)}); convert it to MP4, or "
            "give a folder of its frames"
        )
    stretches = min(count, total)
    best: tuple[float, int, NDArray[np.uint8]] | None = None
    for number, frame in enumerate(tqdm(_frames(video), total=total, desc="frames", leave=False)):
        stretch = number * stretches // total
        if best is not None and best[1] != stretch:
            _write(best, target)
            best = None
        grey = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        sharpness = float(cv2.Laplacian(grey, cv2.CV_64F).var())
        if best is None or sharpness > best[0]:
            best = sharpness, stretch, frame
    if best is not None:
        _write(best, target)


def _frames(video: Path) -> Iterator[NDArray[np.uint8]]:
    """The frames as BGR ``[H, W, 3]``, one at a time."""
    capture = cv2.VideoCapture(str(video))
    try:
        while True:
            found, frame = capture.read()
            if not found:
                return
            yield np.asarray(frame, dtype=np.uint8)
    finally:
        capture.release()


def _write(best: tuple[float, int, NDArray[np.uint8]], target: Path) -> None:
    _, number, frame = best
    rgb = cv2.cvtColor(frame, cv2.COLOR_BGR2RGB).astype(np.uint8)
    write_image(target / f"frame_{number:05d}.png", rgb)
