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
from r3gw.masks.found import load_found
from r3gw.reporting.changes import changes, read_settings
from r3gw.reporting.columns import pictured_protocols
from r3gw.reporting.figures.plots import is_swept, sweep_plot, training_plot
from r3gw.reporting.figures.points import initial_figure, sfm_figure
from r3gw.reporting.figures.truth import depth_pictures, truth_pictures
from r3gw.reporting.page.inline import figure_uri, mask_uri, picture_uri, plot_uri
from r3gw.reporting.runs import Run, load_run
from r3gw.scene import Scene, View, load_points, load_scene

PHOTO_PX, VIEW_PX, LIGHT_PX = 240, 420, 128
NUM_DECOMPOSED = 2
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
    """Where a scene and its runs are: ``root``/{scene,masks,initial.npz,<variant>/seed<k>}.

    Attributes:
        root: Folder of the scene.
        runs: Folders of the runs to show, the main one first.
        page: Address of the page that relights the scene, from the report's folder; None if there
            is none.
    """

    root: Path
    runs: tuple[Path, ...]
    page: str | None = None


def scene_page(folders: SceneFolders) -> Page:
    """Everything of one scene; the first run is the one that is shown.

    Raises:
        InputError: If a file is missing.
    """
    folder = folders.root / "scene"
    scene, points = load_scene(folder), load_points(folder)
    runs = [load_run(each / "metrics" / "metrics.json") for each in folders.runs]
    main = runs[0]
    shown = main.shown_views(scene)
    return {
        "name": folders.root.name,
        "views": [_view_row(main, view, folder) for view in shown],
        "sessions": _sessions(scene, folders.root, folders.runs[0]),
        "num_views": {which: len(scene.split(which)) for which in ("train", "test")},
        "num_points": len(points.xyz),
        "sfm": figure_uri(sfm_figure(scene, points)),
        "initial": figure_uri(initial_figure(scene, points, folders.root / "initial.npz")),
        "lights": _lights(main, scene, folder),
        "parts": [_parts(main, view, folder) for view in shown[:NUM_DECOMPOSED]],
        "page": folders.page,
        "relit": _relit(main),
        "relit_views": list(main.relit.views),
        "training": plot_uri(training_plot(runs)),
        "sweep": plot_uri(sweep_plot(main)) if is_swept(main) else None,
        "settings": _settings(folders.runs, runs),
        "runs": [{"label": run.label, **run.provenance} for run in runs],
        "source": {"format": scene.source_format, "gauge": scene.scene_from_source.scale},
    }


def _view_row(run: Run, view: View, folder: Path) -> Page:
    """Photo and renders of a view, with their figures."""
    photo = picture_uri(read_rgb(folder / view.image), VIEW_PX)
    cells = [{"title": "photo", "uri": photo, "figures": _well_seen(run, view)}]
    for protocol in pictured_protocols():
        record = run.records.get((view.name, protocol.name))
        if record is not None:
            figures = f"{record['psnr']:.2f} dB, SSIM {record['ssim']:.3f}"
            uri = _shown(run, view.name, protocol.name)
            cells.append({"title": protocol.light_title, "uri": uri, "figures": figures})
    return {"name": view.name, "cells": cells}


def _well_seen(run: Run, view: View) -> str:
    """Which share of the view's surfaces photos saw well; empty for runs that do not know it."""
    records = (run.records.get((view.name, protocol.name)) for protocol in pictured_protocols())
    share = next((record.get("well_seen") for record in records if record is not None), None)
    return "" if share is None else f"{100 * share:.0f} % of its surfaces well seen"


def _shown(run: Run, view: str, kind: str) -> str:
    picture = run.picture(view, kind)
    if picture is None:
        raise InputError(f"{run.picture_path(view, kind)}: no such file; evaluate the run again")
    return picture_uri(picture, VIEW_PX)


def _sessions(scene: Scene, root: Path, run: Path) -> list[Page]:
    """Photos by session, with their masks and the occluders that a run found."""
    ordered = sorted(scene.views, key=lambda view: (view.session or "", view.name))
    sessions = []
    for session, views in groupby(ordered, key=lambda view: view.session or ""):
        photos = []
        for view in views:
            is_valid, is_sky = load_masks(root / "masks", view)
            found = load_found(run, view)
            if found is not None:
                is_valid = is_valid & ~found
            photos.append(
                {
                    "name": view.name,
                    "short": view.name.removeprefix(session).strip("_") or view.name,
                    "split": view.split,
                    "uri": picture_uri(read_rgb(root / "scene" / view.image), PHOTO_PX),
                    "masks": mask_uri(is_valid, is_sky, PHOTO_PX),
                }
            )
        sessions.append({"name": session or "no session known", "photos": photos})
    return sessions


def _lights(run: Run, scene: Scene, folder: Path) -> list[Page]:
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


def _parts(run: Run, view: View, folder: Path) -> Page:
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


def _relit(run: Run) -> list[Page]:
    relit = run.relit
    return [
        {
            "photo": photo,
            "map": picture_uri(relit.learned_map(number), LIGHT_PX),
            "views": [picture_uri(relit.learned(view, number), VIEW_PX) for view in relit.views],
        }
        for number, photo in enumerate(relit.photos)
    ]


def _settings(folders: Sequence[Path], runs: Sequence[Run]) -> Page:
    """The main run's settings as text, and what the other variants change."""
    main, *others = [read_settings(folder) for folder in folders]
    changed = [
        {"label": run.label, "changed": changes(main, other)}
        for run, other in zip(runs[1:], others, strict=True)
    ]
    return {"text": json.dumps(main, indent=2), "changes": changed}
