"""What the report shows of one scene, ready for the template: texts, tables and data URIs."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from r3gw.evaluation.gallery import THUMBNAIL_PX, light_picture
from r3gw.files import InputError
from r3gw.imaging.files import read_rgb
from r3gw.lighting import envmap
from r3gw.masks.folder import load_masks
from r3gw.reporting.figures.evaluated import Evaluated, read_run
from r3gw.reporting.figures.plots import sweep_plot, training_plot
from r3gw.reporting.figures.points import initial_figure, sfm_figure
from r3gw.reporting.figures.truth import depth_pictures, truth_pictures
from r3gw.reporting.page.inline import figure_uri, mask_uri, picture_uri, plot_uri
from r3gw.scene import Scene, View, load_points, load_scene

PHOTO_PX, VIEW_PX, LIGHT_PX = 240, 420, 128
NUM_DECOMPOSED = 2
SHOWN_PROTOCOLS = {
    "exact": "true light",
    "nerf-osr": "protocol nerf-osr",
    "learned": "learned light",
}
PARTS = {
    "albedo": "albedo",
    "normal": "normals",
    "depth": "depth",
    "foreground": "foreground alone",
    "sky": "sky alone",
}

Page = dict[str, Any]


@dataclass(frozen=True)
class SceneFolders:
    """Where a scene and its runs are: ``root``/{scene,masks,initial.npz,<variant>/seed<k>}."""

    root: Path
    runs: tuple[Path, ...]


def scene_page(folders: SceneFolders) -> Page:
    """Everything of one scene; the first run is the one that is shown.

    Raises:
        InputError: If a file is missing.
    """
    folder = folders.root / "scene"
    scene, points = load_scene(folder), load_points(folder)
    runs = [read_run(each) for each in folders.runs]
    main = runs[0]
    shown = main.shown_views(scene)
    is_swept = any(protocol == "nerf-osr" for _, protocol in main.records)
    return {
        "name": folders.root.name,
        "views": [_view_row(main, view) for view in shown],
        "sessions": _sessions(scene, folder, folders.root / "masks"),
        "num_views": {which: len(scene.split(which)) for which in ("train", "test")},
        "num_points": len(points.xyz),
        "sfm": figure_uri(sfm_figure(scene, points)),
        "initial": figure_uri(initial_figure(scene, points, folders.root / "initial.npz")),
        "lights": _lights(main, scene, folder),
        "parts": [_parts(main, view, folder) for view in shown[:NUM_DECOMPOSED]],
        "turned": _turned(main),
        "relit": _relit(main),
        "training": plot_uri(training_plot(runs)),
        "sweep": plot_uri(sweep_plot(main)) if is_swept else None,
        "settings": _settings(folders.runs, runs),
        "runs": [{"label": run.label, **run.run} for run in runs],
        "source": {"format": scene.source_format, "gauge": scene.scene_from_source.scale},
    }


def _view_row(run: Evaluated, view: View) -> Page:
    """Photo and renders of a view, with their figures."""
    cells = [{"title": "photo", "uri": _shown(run, view.name, "truth"), "figures": ""}]
    for protocol, title in SHOWN_PROTOCOLS.items():
        record = run.records.get((view.name, protocol))
        if record is not None:
            figures = f"{record['psnr']:.2f} dB, SSIM {record['ssim']:.3f}"
            uri = _shown(run, view.name, protocol)
            cells.append({"title": title, "uri": uri, "figures": figures})
    return {"name": view.name, "cells": cells}


def _shown(run: Evaluated, view: str, kind: str) -> str:
    picture = run.picture(view, kind)
    if picture is None:
        raise InputError(f"{run.renders / kind / view}.png: no such file; evaluate the run again")
    return picture_uri(picture, VIEW_PX)


def _sessions(scene: Scene, folder: Path, masks: Path) -> list[Page]:
    """Photos with their masks, by session."""
    ordered = sorted(scene.views, key=lambda view: (view.session or "", view.name))
    sessions = []
    for session, views in groupby(ordered, key=lambda view: view.session or ""):
        photos = []
        for view in views:
            is_valid, is_sky = load_masks(masks, view)
            photos.append(
                {
                    "name": view.name,
                    "short": view.name.removeprefix(session).strip("_") or view.name,
                    "split": view.split,
                    "uri": picture_uri(read_rgb(folder / view.image), PHOTO_PX),
                    "masks": mask_uri(is_valid, is_sky, PHOTO_PX),
                }
            )
        sessions.append({"name": session or "no session known", "photos": photos})
    return sessions


def _lights(run: Evaluated, scene: Scene, folder: Path) -> list[Page]:
    """Photos beside the light learned for each, every light at its own exposure."""
    lights = []
    for view in scene.split("train"):
        if view.name not in run.lights:
            continue
        drawn = envmap.draw(run.lights[view.name].sh, THUMBNAIL_PX)
        lights.append(
            {
                "name": view.name,
                "photo": picture_uri(read_rgb(folder / view.image), LIGHT_PX),
                "uri": picture_uri(light_picture(drawn), LIGHT_PX),
            }
        )
    return lights


def _parts(run: Evaluated, view: View, folder: Path) -> Page:
    """What a view is made of, and beneath it the truth where it is known."""
    truth = {} if view.truth is None else truth_pictures(view.truth, folder)
    depths = depth_pictures(run.depth(view.name), view.truth, folder)
    cells = []
    for kind, title in PARTS.items():
        ours, true = None, truth.get(kind)
        if kind == "depth":
            ours, true, title = depths.ours, depths.truth, f"{title}, {depths.label}"
        uri = _shown(run, view.name, kind) if ours is None else picture_uri(ours, VIEW_PX)
        beneath = None if true is None else picture_uri(true, VIEW_PX)
        cells.append({"title": title, "uri": uri, "truth": beneath})
    return {"name": view.name, "cells": cells}


def _turned(run: Evaluated) -> Page:
    """Frames of the slider: every view and the map at every turn."""
    relit = run.relit
    frames = [
        {
            "yaw_deg": yaw,
            "map": picture_uri(relit.turned_map(yaw), LIGHT_PX),
            "views": [picture_uri(relit.turned(view, yaw), VIEW_PX) for view in relit.views],
        }
        for yaw in relit.yaws_deg
    ]
    return {"map": relit.map_name, "views": list(relit.views), "frames": frames}


def _relit(run: Evaluated) -> list[Page]:
    relit = run.relit
    return [
        {
            "photo": photo,
            "map": picture_uri(relit.learned_map(number), LIGHT_PX),
            "views": [picture_uri(relit.learned(view, number), VIEW_PX) for view in relit.views],
        }
        for number, photo in enumerate(relit.photos)
    ]


def _settings(folders: Sequence[Path], runs: Sequence[Evaluated]) -> Page:
    """The main run's settings as text, and what the other variants change."""
    texts = []
    for folder in folders:
        path = folder / "settings.json"
        if not path.is_file():
            raise InputError(f"{path}: no such file; train the run again")
        texts.append(path.read_text())
    main, *others = [_flat(json.loads(text)) for text in texts]
    changes = []
    for run, other in zip(runs[1:], others, strict=True):
        keys = sorted(key for key in main.keys() | other.keys() if main.get(key) != other.get(key))
        changed = [{"key": k, "from": main.get(k), "to": other.get(k)} for k in keys]
        changes.append({"label": run.label, "changed": changed})
    return {"text": texts[0], "changes": changes}


def _flat(settings: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in settings.items():
        if isinstance(value, dict):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[prefix + key] = value
    return flat
