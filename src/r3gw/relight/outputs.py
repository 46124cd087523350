"""Where frames go: one picture, numbered pictures, or a film, by the name of the file.

``relit.png`` is one picture, ``frames/%04d.png`` numbered ones (from 0), ``relit.mp4`` a film
(H.264, yuv420p, which browsers and players know). ``.exr`` pictures are linear light.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Generator
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError, atomic_path
from r3gw.files.extras import optional_module
from r3gw.imaging.files import WRITTEN_SUFFIXES, write_exr, write_image
from r3gw.imaging.pictures import bytes_from_display

FILM_SUFFIX = ".mp4"
LINEAR_SUFFIX = ".exr"
FILM_QUALITY = ["-crf", "18", "-preset", "medium", "-movflags", "+faststart"]
NUMBER = re.compile(r"%0?\d*d")


class Output(ABC):
    """Takes the frames of a film in order; a context manager, complete when it is left."""

    is_linear = False

    def __enter__(self) -> "Output":
        return self

    @abstractmethod
    def write(self, picture: Float[Tensor, "h w 3"]) -> None:
        """Take the next frame: display values, or linear light if ``is_linear``."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        return None


class Pictures(Output):
    """One picture file per frame."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.is_linear = path.suffix.lower() == LINEAR_SUFFIX
        self.count = 0

    def write(self, picture: Float[Tensor, "h w 3"]) -> None:
        """Write the frame under its number."""
        target = numbered(self.path, self.count)
        self.count += 1
        if self.is_linear:
            write_exr(target, picture.numpy())
        else:
            write_image(target, bytes_from_display(picture))


class Film(Output):
    """An MP4 film; an odd last row or column is left out, because yuv420p halves the size."""

    def __init__(self, path: Path, fps: float) -> None:
        self.path, self.fps = path, fps
        self.ffmpeg = optional_module("imageio_ffmpeg")
        self.stack = ExitStack()
        self.sink: Generator[None, Any, None] | None = None

    def write(self, picture: Float[Tensor, "h w 3"]) -> None:
        """Encode the frame."""
        pixels = bytes_from_display(picture)
        height, width = pixels.shape[0] // 2 * 2, pixels.shape[1] // 2 * 2
        if self.sink is None:
            temporary = self.stack.enter_context(atomic_path(self.path))
            self.sink = self.ffmpeg.write_frames(
                str(temporary),
                (width, height),
                fps=self.fps,
                codec="libx264",
                quality=None,
                macro_block_size=1,
                output_params=FILM_QUALITY,
            )
            self.sink.send(None)
        self.sink.send(np.ascontiguousarray(pixels[:height, :width]))

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.sink is not None:
            self.sink.close()
        self.stack.__exit__(kind, error, trace)


def described(path: Path, frames: int, fps: float) -> str:
    """An output that is complete, in words: its name, and what is in it where that is more."""
    if path.suffix.lower() == FILM_SUFFIX:
        return f"{path} ({frames} frames, {frames / fps:.1f} s)"
    if not NUMBER.search(path.name):
        return str(path)
    first, last = numbered(path, 0), numbered(path, frames - 1)
    return str(first) if frames == 1 else f"{first} to {last.name}"


def numbered(path: Path, number: int) -> Path:
    """The file of a frame: the pattern in the name, such as ``%04d``, replaced by its number."""
    return path.with_name(NUMBER.sub(lambda found: found.group() % number, path.name))


def output_for(path: Path, frames: int, fps: float) -> Output:
    """The output that a file name asks for.

    Raises:
        InputError: If the suffix is unknown, or several frames would overwrite one picture.
    """
    suffix = path.suffix.lower()
    if suffix == FILM_SUFFIX:
        return Film(path, fps)
    if suffix not in (*WRITTEN_SUFFIXES, LINEAR_SUFFIX):
        known = ", ".join((*WRITTEN_SUFFIXES, LINEAR_SUFFIX, FILM_SUFFIX))
        raise InputError(f"{path}: cannot write '{suffix}' files; the name must end in {known}")
    if frames > 1 and not NUMBER.search(path.name):
        raise InputError(
            f"{path}: {frames} frames need {FILM_SUFFIX} or a number in the name, "
            f"such as {path.stem}_%04d{suffix}"
        )
    return Pictures(path)
