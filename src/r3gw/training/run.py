"""The training stage: files in, ``model.pt``, ``history.csv`` and ``run.json`` out."""

import gc
from collections.abc import Sequence
from pathlib import Path

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import write_json
from r3gw.files.provenance import code_version, digest, machine, peak_rss_mb
from r3gw.model.initial import load_initial
from r3gw.model.model import initial_model, light_rows, save_model
from r3gw.model.settings import TrainSettings, load_train_settings
from r3gw.native import ops
from r3gw.scene import load_scene
from r3gw.training.loop import train
from r3gw.training.photos import Photo, load_photos
from r3gw.training.state import Checkpoints
from r3gw.training.visible_sky import VisibleSky, first_sky


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
    """Train and write ``target``/{model.pt, history.csv, run.json}; run.json is written last.

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
    skies = first_skies(photos, light_rows(sessions, settings), settings)
    start = initial_model(load_initial(initial_path), names, settings, sessions, skies)
    checkpoints = Checkpoints(target, start)
    # What is loaded by now stays: the collector need not walk it during every iteration.
    gc.freeze()
    model, history = train(start, photos, checkpoints)
    save_model(model, target / "model.pt")
    history.write(target / "history.csv")
    record = {
        "scene": scene,
        "variant": variant,
        "seed": settings.seed,
        "iterations": settings.iterations,
        "settings_digest": digest(settings.model_dump(mode="json")),
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


def first_skies(
    photos: Sequence[Photo], rows: Sequence[int], settings: TrainSettings
) -> Float[Tensor, "s 4 3"]:
    """Per row of the embedding, the sky that its photos show."""
    seen: list[list[VisibleSky]] = [[] for _ in range(max(rows) + 1)]
    for photo, row in zip(photos, rows, strict=True):
        if photo.seen_sky is not None:
            seen[row].append(photo.seen_sky)
    return torch.stack([first_sky(photos_sky, settings.init.light_radiance) for photos_sky in seen])
