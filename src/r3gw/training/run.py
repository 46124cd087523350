"""The training stage: files in, ``model.safetensors``, ``history.csv`` and ``run.json`` out."""

import gc
import logging
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import torch

from r3gw.files import InputError, write_json
from r3gw.files.imports import Imports
from r3gw.files.provenance import code_version, digest, machine, peak_rss_mb
from r3gw.files.strict import read_json
from r3gw.masks.found import save_found
from r3gw.model.initial import load_initial
from r3gw.model.model_file import save_model
from r3gw.native import ops
from r3gw.native.code import PACKAGE, code_digest
from r3gw.native.extension import LEVEL
from r3gw.scene import load_scene
from r3gw.training.checkpoint import INTERVAL_S, Checkpoints
from r3gw.training.first_values import with_first_values
from r3gw.training.loop import train
from r3gw.training.photos import load_photos
from r3gw.training.run_digest import run_digest, run_parts
from r3gw.training.settings import TrainSettings, load_train_settings
from r3gw.training.snapshots import Snapshots
from r3gw.training.start import model_of_photos
from r3gw.training.state import TrainingState
from r3gw.training.watched import Watched

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class RunFiles:
    """Where a training finds its inputs and leaves its results.

    Attributes:
        scene: Folder of the imported scene.
        masks: Folder of its masks.
        initial: ``initial.npz``.
        settings: Resolved settings (JSON).
        target: Folder of the run.
    """

    scene: Path
    masks: Path
    initial: Path
    settings: Path
    target: Path


def run_training(
    files: RunFiles,
    *,
    scene: str,
    variant: str,
    num_threads: int,
    checkpoint_s: float = INTERVAL_S,
    fresh: bool = False,
    snapshots: Collection[int] = (),
) -> None:
    """Train and write model.safetensors, history.csv, timing.json and, last, run.json.

    Where occluders are looked for, is_occluder/ holds those that were found (r3gw.masks.found).

    What was measured is in timing.json alone, so a second run on the same machine gives the same
    bytes in all other files.

    A run that was interrupted is continued where its last checkpoint stands, if everything that it
    depends on is still the same.

    Args:
        files: Inputs and target.
        scene: The scene's name, for the record.
        variant: The variant's name, for the record.
        num_threads: CPU threads of torch and the rasterizer.
        checkpoint_s: Seconds between checkpoints.
        fresh: Begin anew even where a checkpoint stands.
        snapshots: Iterations after which the run so far is written, in the form of a finished one,
            to ``snapshots/<iteration>`` below the target.

    Raises:
        InputError: If an input is missing or malformed, or training diverges.
    """
    torch.set_num_threads(num_threads)
    ops.keep_freed_memory()
    imported = load_scene(files.scene)
    photos = load_photos(imported, files.scene, files.masks)
    asked = load_train_settings(files.settings)
    settings = with_first_values(asked, photos)
    initial = load_initial(files.initial)
    sessions = tuple(view.session or view.name for view in imported.split("train"))
    start = model_of_photos(initial, photos, settings, sessions)
    values = asked.model_dump(mode="json")
    parts = run_parts(values, _code(), photos, sessions, initial, num_threads)
    checkpoints = Checkpoints(files.target, parts, checkpoint_s)
    if fresh:
        checkpoints.discard()
    _say_why_not_lengthened(files.target, settings)
    # What is loaded by now stays: the collector need not walk it during every iteration.
    gc.freeze()
    watched = Watched(files.target)
    run = {"scene": scene, "variant": variant}
    write = partial(_write, run=run, settings=values, parts=parts, num_threads=num_threads)
    kept = Snapshots(files.target, snapshots, write)
    state = train(start, photos, settings, checkpoints, watched, kept)
    write(state, files.target)
    checkpoints.discard()
    watched.discard()


def _write(
    state: TrainingState,
    target: Path,
    *,
    run: Mapping[str, str],
    settings: Mapping[str, Any],
    parts: Mapping[str, str],
    num_threads: int,
) -> None:
    """Write the run as it stands; run.json, which says that it is whole, last."""
    save_model(state.model, target / "model.safetensors", settings)
    state.history.write(target / "history.csv")
    found = zip(state.model.photos, state.occluders, strict=False)
    save_found(target, {name: mask.numpy() for name, mask in found})
    timing = {"training_seconds": state.history.seconds(), "peak_rss_mb": peak_rss_mb()}
    write_json(target / "timing.json", timing)
    write_json(target / "run.json", {**run, **_record(state, settings, parts, num_threads)})


def _record(
    state: TrainingState, settings: Mapping[str, Any], parts: Mapping[str, str], num_threads: int
) -> dict[str, Any]:
    """What run.json says of a finished run besides its names; nothing that was measured."""
    return {
        "seed": state.settings.seed,
        "iterations": state.iteration,
        "settings_digest": digest(settings),
        "first_light": state.settings.init.light_radiance,
        "run_digest": run_digest(parts),
        "depends_on": dict(parts),
        "code_version": code_version(),
        "machine": machine(),
        "kernels": LEVEL,
        "num_threads": num_threads,
        "num_foreground": len(state.model.foreground),
        "num_sky": len(state.model.sky.rows),
        "notes": state.notes,
        "known_suns": state.tied_suns.record() if state.tied_suns.yaw_deg is not None else None,
    }


def _code() -> str:
    """Digest of all code that this stage can reach."""
    return code_digest([__name__], Imports(PACKAGE))


def _say_why_not_lengthened(target: Path, settings: TrainSettings) -> None:
    """Explain, where a shorter finished run lies, why this one does not go on from it."""
    record = target / "run.json"
    if not record.is_file():
        return
    try:
        done = read_json(record).get("iterations")
    except InputError:  # it is about to be written anew
        return
    if isinstance(done, int) and done < settings.iterations:
        log.warning(
            "%s: the finished run of %d iterations is not lengthened to %d but made anew, because "
            "learning rates, densification and shadows follow a schedule over the whole length",
            record,
            done,
            settings.iterations,
        )
