"""Models of a run on its way, each in a folder that is evaluated as that of a finished run."""

import logging
from collections.abc import Callable, Iterable
from pathlib import Path

from r3gw.training.health import require_finite_parameters
from r3gw.training.state import TrainingState

log = logging.getLogger(__name__)

Write = Callable[[TrainingState, Path], None]


class Snapshots:
    """Writes the run to ``snapshots/<iteration>`` after chosen iterations."""

    def __init__(self, folder: Path, iterations: Iterable[int], write: Write) -> None:
        """Write with ``write`` below the run's ``folder`` after each of ``iterations``."""
        self.folder = folder / "snapshots"
        self.iterations = frozenset(iterations)
        self._write = write

    def save_if_due(self, state: TrainingState) -> None:
        """Write the run if this iteration is a chosen one; a full disk does not end the run.

        Raises:
            Diverged: If the state is not fit to be kept.
        """
        if state.iteration not in self.iterations:
            return
        require_finite_parameters(state)
        target = self.folder / str(state.iteration)
        try:
            self._write(state, target)
        except OSError as error:
            log.warning("%s is not written (%s); training goes on", target, error.strerror)
