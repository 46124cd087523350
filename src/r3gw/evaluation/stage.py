"""The evaluation stage: a trained model in, figures per image, lights and pictures out.

metrics.json holds ``run`` (run.json of the training, as it is), ``images`` (one record per view and
protocol) and ``decomposition`` (one record per view and kind of comparison). Every image record
also stands alone in images/<protocol>/<view>.json, with the run that it belongs to. cost.json holds
all seconds and memory, those of the training's timing.json too; all other files are the same for
the same model.
"""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import torch
from tqdm import tqdm

from r3gw.evaluation.cost import measured_cost
from r3gw.evaluation.decomposition import light_records, sky_records, surface_records
from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.evaluation.gallery import write_gallery
from r3gw.evaluation.protocols.base import Outcome
from r3gw.evaluation.protocols.facts import ProtocolFacts
from r3gw.evaluation.protocols.registry import PROTOCOLS
from r3gw.files import InputError, write_json
from r3gw.files.strict import read_json
from r3gw.imaging.colour import display_array_from_linear
from r3gw.imaging.files import write_exr, write_image
from r3gw.imaging.pictures import bytes_from_display, depth_picture, normal_picture
from r3gw.model.lights import learned_lights
from r3gw.model.model_file import load_model
from r3gw.relight.files.lights_file import write_lights
from r3gw.relight.gaussians import relightable_of
from r3gw.relight.seen import Coverage
from r3gw.rendering.compose import sunlight_of
from r3gw.rendering.surfaces import foreground_and_sky, surfaces_of
from r3gw.scene import View, load_scene
from r3gw.scene.selection import evenly

NUM_LEARNED_PICTURES = 4
# Figures of the training's timing.json, and their names in cost.json.
MEASURED = {"training_seconds": "training_seconds", "peak_rss_mb": "training_peak_rss_mb"}
VISIBLE_ALPHA = 0.5


def evaluate_run(
    scene_folder: Path, masks_folder: Path, model_path: Path, target: Path, *, num_threads: int
) -> None:
    """Score a trained model and draw its pictures; metrics.json is written last.

    Args:
        scene_folder: Imported scene.
        masks_folder: Its masks.
        model_path: model.safetensors, with the training's run.json and timing.json beside it.
        target: Folder for metrics.json, lights.json, cost.json, images/<protocol>/<view>.json,
            renders/ and relit/ (`write_gallery`). renders/ holds, of all test views and of four
            training views, ``<kind>/<view>.png`` where a kind is a protocol or one of albedo,
            normal, depth, sky, foreground; depth also as ``.exr``.
        num_threads: CPU threads of torch and the rasterizer.

    Raises:
        InputError: If an input is missing or malformed, or a mask leaves no pixel.
    """
    torch.set_num_threads(num_threads)
    run = _read(model_path.with_name("run.json"))
    timing = _read(model_path.with_name("timing.json"))
    spent = {name: timing.get(key) for key, name in MEASURED.items()}
    scene = load_scene(scene_folder)
    evaluated = EvaluatedScene(load_model(model_path), scene, scene_folder, masks_folder)
    (target / "metrics.json").unlink(missing_ok=True)
    for name in ("renders", "images", "relit"):
        shutil.rmtree(target / name, ignore_errors=True)
    images = _protocol_records(evaluated, target / "renders", str(run["scene"]))
    for image in images:
        path = target / "images" / image["protocol"] / f"{image['view']}.json"
        write_json(path, {**image, "run": run})
    write_gallery(evaluated, target / "relit")
    write_lights(learned_lights(evaluated.model), "scene", target)
    write_json(target / "cost.json", spent | measured_cost(evaluated, num_threads))
    decomposition = surface_records(evaluated) + light_records(evaluated) + sky_records(evaluated)
    write_json(
        target / "metrics.json", {"run": run, "images": images, "decomposition": decomposition}
    )


def _read(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise InputError(f"{path}: no such file; train the scene again")
    return read_json(path)


def _protocol_records(evaluated: EvaluatedScene, folder: Path, scene: str) -> list[dict[str, Any]]:
    """Score every view under every protocol that covers it, and write pictures on the way.

    Records tell which share of a picture's surfaces photos saw well (`r3gw.relight.seen`), None
    where it shows none.
    """
    train = evaluated.scene.split("train")
    pictured = {view.name for view in evenly(train, NUM_LEARNED_PICTURES)}
    coverage = Coverage(relightable_of(evaluated.model), [view.camera for view in train])
    records = []
    for view in tqdm(evaluated.scene.views, desc=f"evaluating {scene}", unit="view", leave=False):
        outcomes, well_seen = [], coverage.share(view.camera)
        for protocol in PROTOCOLS:
            outcome = protocol.evaluate(evaluated, view) if protocol.facts.covers(view) else None
            if outcome is None:
                continue
            outcomes.append((protocol.facts.rank, outcome))
            records.append(_record(protocol.facts, view, scene, outcome) | {"well_seen": well_seen})
            if view.split == "test" or view.name in pictured:
                path = folder / protocol.facts.name / f"{view.name}.png"
                write_image(path, bytes_from_display(outcome.picture))
        if outcomes and (view.split == "test" or view.name in pictured):
            _, shown = min(outcomes, key=lambda ranked: ranked[0])
            _write_parts(evaluated, view, shown, folder)
    return records


def _record(protocol: ProtocolFacts, view: View, scene: str, outcome: Outcome) -> dict[str, Any]:
    return {
        "scene": scene,
        "view": view.name,
        "session": view.session,
        "protocol": protocol.name,
        "protocol_version": protocol.version,
        "is_oracle": protocol.is_oracle,
        **outcome.figures,
    }


def _write_parts(evaluated: EvaluatedScene, view: View, outcome: Outcome, folder: Path) -> None:
    """What the picture of ``outcome`` is made of."""
    surfaces = surfaces_of(evaluated.model, view.camera)
    is_surface = surfaces.foreground_alpha >= VISIBLE_ALPHA
    depth = np.where(is_surface, surfaces.depth, 0.0).astype(np.float32)
    albedo = np.where(is_surface[..., None], display_array_from_linear(surfaces.albedo), 1.0)
    light = outcome.light
    foreground, sky = foreground_and_sky(
        evaluated.model,
        view.camera,
        light.sh,
        light.sky_coefficients,
        sunlight_of(evaluated.model, view.camera, light.point),
    )
    parts = {
        "albedo": bytes_from_display(albedo),
        "normal": normal_picture(np.where(is_surface[..., None], surfaces.normal, 0.0)),
        "depth": depth_picture(depth),
        "foreground": bytes_from_display(foreground),
        "sky": bytes_from_display(sky),
    }
    for kind, picture in parts.items():
        write_image(folder / kind / f"{view.name}.png", picture)
    write_exr(folder / "depth" / f"{view.name}.exr", np.repeat(depth[..., None], 3, axis=2))
