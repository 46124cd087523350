"""The training stage: files in, ``model.safetensors``, ``history.csv`` and ``run.json`` out."""

import gc
from pathlib import Path

import torch

from r3gw.files import write_json
from r3gw.files.provenance import code_version, digest, machine, peak_rss_mb
from r3gw.model.initial import load_initial
from r3gw.model.model_file import save_model
from r3gw.native import ops
from r3gw.scene import load_scene
from r3gw.training.checkpoint import Checkpoints
from r3gw.training.loop import train
from r3gw.training.photos import load_photos
from r3gw.training.settings import load_train_settings
from r3gw.training.start import initial_model


def run_training(
    scene_folder: Path,
    masks_folder: Path,
    initial_path: Path,
    settings_path: Path,
    target: Path,
    *,
    scene: str,
    variant: str,
    num_threads: int,
) -> None:
    """Train and write model.safetensors, history.csv and, last, run.json into ``target``.

    Args:
        scene_folder: Imported scene.
        masks_folder: Its masks.
        initial_path: ``initial.npz``.
        settings_path: Resolved settings (JSON).
        target: Folder of the run.
        scene, variant: Names for the record.
        num_threads: CPU threads of torch and the rasterizer.

    Raises:
        InputError: If an input is missing or malformed, or training diverges.
    """
    torch.set_num_threads(num_threads)
    ops.keep_freed_memory()
    settings = load_train_settings(settings_path)
    imported = load_scene(scene_folder)
    photos = load_photos(imported, scene_folder, masks_folder)
    names = tuple(photo.name for photo in photos)
    sessions = tuple(view.session or view.name for view in imported.split("train"))
    seen = [photo.seen_sky for photo in photos]
    start = initial_model(load_initial(initial_path), names, settings, sessions, seen)
    values = settings.model_dump(mode="json")
    checkpoints = Checkpoints(target, digest(values))
    # What is loaded by now stays: the collector need not walk it during every iteration.
    gc.freeze()
    model, history = train(start, photos, settings, checkpoints)
    save_model(model, target / "model.safetensors", values)
    history.write(target / "history.csv")
    record = {
        "scene": scene,
        "variant": variant,
        "seed": settings.seed,
        "iterations": settings.iterations,
        "settings_digest": digest(values),
        "code_version": code_version(),
        "machine": machine(),
        "num_threads": num_threads,
        "training_seconds": history.seconds(),
        "peak_rss_mb": peak_rss_mb(),
        "num_foreground": len(model.foreground),
        "num_sky": len(model.sky.rows),
    }
    write_json(target / "run.json", record)
    checkpoints.discard()
