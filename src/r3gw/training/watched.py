"""What a training shows to somebody who watches it: the photo just rendered, and the curves so far.

`r3gw.view` asks by touching a file in the run's folder; a training that nobody watches writes
nothing and spends one look at the clock per iteration.
"""

import logging
import time
from pathlib import Path

import numpy as np
import torch

from r3gw.files import write_json
from r3gw.imaging.files import write_image
from r3gw.imaging.pictures import bytes_from_display
from r3gw.rendering.compose import Rendering
from r3gw.training.photos import Photo
from r3gw.training.state import TrainingState

log = logging.getLogger(__name__)

ASKED, CURVES, PICTURE = ".watched", ".watched.json", ".watched.png"
INTERVAL_S = 3.0  # between frames
PATIENCE_S = 20.0  # after the last request


def ask(folder: Path) -> None:
    """Let the training in ``folder`` know that somebody watches; its folder is made if missing."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / ASKED).touch()


class Watched:
    """Writes frame and curves of a run while they are asked for."""

    def __init__(self, folder: Path) -> None:
        """Show the run of ``folder`` there."""
        self.folder = folder
        self._next = 0.0

    def show_if_asked(self, state: TrainingState, photo: Photo, rendering: Rendering) -> None:
        """Write the photo beside its rendering, and the rows of the history so far.

        A disk that takes no more costs the watcher a frame, and the training nothing.
        """
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + INTERVAL_S
        if not _is_asked(self.folder / ASKED):
            return
        try:
            self._show(state, photo, rendering)
        except OSError as error:
            log.warning("nothing is shown to those who watch (%s)", error)

    def _show(self, state: TrainingState, photo: Photo, rendering: Rendering) -> None:
        rendered = rendering.colour.detach().clamp(0.0, 1.0)
        pair = torch.cat([photo.target(), rendered], dim=1)
        write_image(self.folder / PICTURE, np.asarray(bytes_from_display(pair)))
        progress = {
            "photo": photo.name,
            "iteration": state.iteration,
            "iterations": state.settings.iterations,
            "seconds": state.history.seconds(),
            "rows": state.history.rows,
        }
        write_json(self.folder / CURVES, progress)

    def discard(self) -> None:
        """Remove the files: the run is complete."""
        for name in (ASKED, CURVES, PICTURE):
            (self.folder / name).unlink(missing_ok=True)


def _is_asked(path: Path) -> bool:
    try:
        return time.time() - path.stat().st_mtime < PATIENCE_S
    except OSError:
        return False
