"""The checkpoint of a run: a run that continues from one ends as if it had never stopped.

It lies beside the run, under a name with the run's digest, so a state made of other photos, masks,
points, settings or code is never continued. It is no declared output of the workflow (Snakemake
deletes those of interrupted jobs) and goes when training ends.
"""

import logging
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from r3gw.files.arrays import read_arrays, read_record, write_arrays
from r3gw.files.errors import InputError
from r3gw.model.model_file import (
    model_from,
    model_record,
    model_record_from,
    model_tensors,
)
from r3gw.training.health import require_finite_parameters
from r3gw.training.known_suns import TiedSuns
from r3gw.training.run_digest import run_digest
from r3gw.training.settings import TrainSettings
from r3gw.training.state import TrainingState, first_state
from r3gw.training.sun_shadows import SunShadows

log = logging.getLogger(__name__)

INTERVAL_S = 300.0
WHAT = "checkpoint of r3gw"
# What a file of another form makes Python raise.
WRONG_FORM = (KeyError, TypeError, ValueError, RuntimeError, IndexError, AttributeError)
MODEL, OPTIMIZER, SUN_SHADOWS = "model.", "optimizer.", "sun_shadow."
STATISTICS = ("statistics.total", "statistics.views")
GENERATORS = ("generator", "dropout")
MOMENTS = ("step", "exp_avg", "exp_avg_sq")


class Checkpoints:
    """Saves a run every ``interval_s`` seconds and finds it again."""

    def __init__(
        self, folder: Path, parts: Mapping[str, str], interval_s: float = INTERVAL_S
    ) -> None:
        """Keep the checkpoint of the run that depends on ``parts`` (`run_parts`) in ``folder``."""
        self.path = folder / f".checkpoint-{run_digest(parts)}.safetensors"
        self.parts = dict(parts)
        self.interval_s = interval_s
        self._last = time.monotonic()
        self._iteration: int | None = None

    def restore(self, state: TrainingState) -> TrainingState:
        """The saved state if there is one of this run that can be read, else ``state``."""
        for other in self._all():
            if other != self.path:
                log.warning("%s is not continued: %s", other, self._difference(other))
        if not self.path.is_file():
            return state
        try:
            tensors, record = read_arrays(self.path, WHAT)
            restored = _state(tensors, record, state.settings, str(self.path))
        except (InputError, *WRONG_FORM) as error:
            log.warning("%s is not continued, training starts afresh (%s)", self.path, error)
            return first_state(state.model, state.settings)
        self._iteration = restored.iteration
        log.info("continuing from %s at iteration %d", self.path, restored.iteration)
        return restored

    def save_if_due(self, state: TrainingState) -> None:
        """Write the state if the last checkpoint is old enough; a full disk does not end the run.

        Raises:
            Diverged: If it is not fit to be continued; the last checkpoint stays.
        """
        if time.monotonic() - self._last < self.interval_s:
            return
        require_finite_parameters(state)
        self._last = time.monotonic()
        try:
            write_arrays(self.path, _tensors(state), _record(state) | {"run": self.parts})
        except OSError as error:
            log.warning("%s is not written (%s); training goes on", self.path, error.strerror)
        else:
            self._iteration = state.iteration

    def kept(self) -> str:
        """What to say of the last checkpoint when training cannot go on."""
        if self._iteration is None:
            return ""
        return f"; the state of iteration {self._iteration} is kept in {self.path}"

    def discard(self) -> None:
        """Remove all checkpoints in the folder: the run is complete, or begins afresh."""
        # Two dots: what a process was writing when it was killed.
        for path in (*self._all(), *self.path.parent.glob("..checkpoint-*")):
            path.unlink(missing_ok=True)

    def _all(self) -> list[Path]:
        return sorted(self.path.parent.glob(".checkpoint-*"))

    def _difference(self, other: Path) -> str:
        """What a checkpoint of another run was made of."""
        try:
            theirs = read_record(other, WHAT).get("run")
        except InputError:
            return "it is damaged, or of another version of r3gw"
        if not isinstance(theirs, dict):
            return "it does not say what it was made of"
        changed = [name for name, part in self.parts.items() if theirs.get(name) != part]
        return f"it was made of other {' and '.join(changed)}"


def _tensors(state: TrainingState) -> dict[str, Tensor]:
    tensors = {f"{MODEL}{name}": value for name, value in model_tensors(state.model).items()}
    for index, parameter in enumerate(_parameters(state)):
        for key, value in state.optimizer.state.get(parameter, {}).items():
            tensors[f"{OPTIMIZER}{index}.{key}"] = value
    for name, value in state.sun_shadows.tensors().items():
        tensors[f"{SUN_SHADOWS}{name}"] = value
    statistics = (state.statistics.total, state.statistics.views)
    generators = (state.generator.get_state(), torch.get_rng_state())
    pairs = zip((*STATISTICS, *GENERATORS), (*statistics, *generators), strict=True)
    return tensors | dict(pairs)


def _record(state: TrainingState) -> dict[str, Any]:
    return {
        "model": model_record(state.model).model_dump(mode="json"),
        "iteration": state.iteration,
        "order": state.order.left,
        "history": state.history.rows,
        "seconds": state.history.seconds(),
        "notes": state.notes,
        "sun_shadows": state.sun_shadows.record(),
        "tied_suns": state.tied_suns.record(),
    }


def _state(
    tensors: Mapping[str, Tensor], record: Mapping[str, Any], settings: TrainSettings, source: str
) -> TrainingState:
    """Invert `_tensors` and `_record`; raises one of `WRONG_FORM` if they do not fit."""
    model = model_from(_part(tensors, MODEL), model_record_from(record["model"], source), source)
    state = first_state(model, settings)
    for index, parameter in enumerate(_parameters(state)):
        saved = {key: tensors.get(f"{OPTIMIZER}{index}.{key}") for key in MOMENTS}
        if all(value is not None for value in saved.values()):
            state.optimizer.state[parameter] = saved
    state.statistics.total, state.statistics.views = (tensors[name] for name in STATISTICS)
    state.order.left = [int(index) for index in record["order"]]
    state.history.resume(list(record["history"]), float(record["seconds"]))
    state.notes = dict(record["notes"])
    state.sun_shadows = SunShadows.restored(_part(tensors, SUN_SHADOWS), record["sun_shadows"])
    state.tied_suns = TiedSuns.restored(record["tied_suns"])
    state.iteration = int(record["iteration"])
    state.generator.set_state(tensors[GENERATORS[0]])
    torch.set_rng_state(tensors[GENERATORS[1]])
    return state


def _part(tensors: Mapping[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {k.removeprefix(prefix): v for k, v in tensors.items() if k.startswith(prefix)}


def _parameters(state: TrainingState) -> list[Tensor]:
    return [parameter for group in state.optimizer.param_groups for parameter in group["params"]]
