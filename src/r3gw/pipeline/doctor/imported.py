"""The thorough half: an imported scene with its masks, as training and evaluation will see it."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch

from r3gw.evaluation.evaluated_scene import scored_pixels
from r3gw.evaluation.metrics import EROSION_PX
from r3gw.evaluation.protocols.published import published_turn_rad
from r3gw.files import InputError
from r3gw.files.strict import read_json, read_yaml
from r3gw.geometry.cameras import UP, pixel_rays
from r3gw.importing.gauge import roll_deg
from r3gw.importing.named_files import listed
from r3gw.lighting.envmap import read_env_map
from r3gw.masks.folder import load_masks
from r3gw.pipeline.doctor.findings import Findings
from r3gw.scene import Scene, View, load_points
from r3gw.training.photos import read_photo

LEAST_TRAINING_PHOTOS = 3
_FEW_POINTS = 100
_DOUBTFUL_ROLL_DEG = 10.0


def describe_scene(scene: Scene, folder: Path, findings: Findings) -> None:
    """Photos, sizes, registration, sessions, split and points; every photo is read."""
    train, test = scene.split("train"), scene.split("test")
    findings.facts["photos"] = f"{len(scene.views)} ({len(train)} training, {len(test)} test)"
    findings.facts["sizes"] = _sizes(scene.views)
    findings.facts |= _registered(folder)
    sessions = Counter(view.session or "none in the name" for view in scene.views)
    counted = listed(f"{name} ({count})" for name, count in sessions.items())
    findings.facts["sessions"] = f"{len(sessions)}: {counted}"
    findings.attempt(lambda: _enough(train, folder))
    for view in scene.views:
        findings.attempt(partial(read_photo, view, folder))
    points = findings.attempt(lambda: load_points(folder))
    if points is not None:
        findings.facts["sparse points"] = f"{len(points.xyz):,}"
        if len(points.xyz) < _FEW_POINTS:
            findings.warnings.append(
                f"only {len(points.xyz)} sparse points: training starts from very little; "
                "photos with more texture and overlap give more"
            )


def _sizes(views: Sequence[View]) -> str:
    counts = Counter((view.width, view.height) for view in views)
    sizes = [f"{w}x{h} px ({count})" for (w, h), count in sorted(counts.items())]
    shown = ", ".join(sizes[:4]) + (f" and {len(sizes) - 4} more sizes" if len(sizes) > 4 else "")
    scaled = sum(view.source_size_px is not None for view in views)
    return shown + (f"; {scaled} were larger and are scaled down" if scaled else "")


def _registered(folder: Path) -> dict[str, str]:
    """How many photos have cameras, which do not, and what the import decided besides."""
    path = folder / "sfm_report.json"
    if not path.is_file():  # imported before every format had a report
        return {"registered": "cameras came with the data"}
    report = read_json(path)
    lost = listed(report["not_registered"])
    found = f"{len(report['registered'])} of {report['photos']}"
    facts = {"registered": found + (f"; left out: {lost}" if lost else "")}
    notes = report.get("notes", [])
    return facts | ({"import": "; ".join(notes)} if notes else {})


def _enough(train: Sequence[View], folder: Path) -> None:
    if len(train) < LEAST_TRAINING_PHOTOS:
        count = "only 1 training photo is" if len(train) == 1 else f"only {len(train)} are"
        raise InputError(
            f"{folder / 'scene.json'}: {count} left, but at least {LEAST_TRAINING_PHOTOS} training "
            "photos are needed; add photos or correct the split"
        )


def describe_masks(scene: Scene, masks: Path, findings: Findings) -> None:
    """Coverage, sources and polarity of the masks; whether the sky is where up says."""
    record = findings.attempt(lambda: read_yaml(masks / "masks.json"))
    if record is None:
        return
    views = record["views"]
    sky = [views[view.name]["is_sky"] for view in scene.views if view.name in views]
    valid = [views[view.name]["is_valid"] for view in scene.views if view.name in views]
    if missing := [view.name for view in scene.views if view.name not in views]:
        findings.problems.append(
            f"{masks / 'masks.json'}: lacks {listed(missing)}; run the mask stage again"
        )
        return
    findings.facts["sky masks"] = f"{_sources(sky)}; cover {_coverage(sky)}"
    findings.facts["polarity"] = _counted(entry.get("polarity", "unclear") for entry in sky)
    visible = sum(entry["share"] > 0 for entry in sky)
    findings.facts["sky visible"] = f"in {visible} of {len(sky)} photos"
    findings.facts["valid pixels"] = f"{_sources(valid)}; cover {_coverage(valid)}"
    findings.warnings += record.get("warnings", [])
    if visible == 0:
        findings.warnings.append(
            "no photo shows sky: the sky's light is learned from nothing; look at the masks"
        )
    _check_up_with_sky(scene, masks, findings)


def _sources(entries: Sequence[Mapping[str, Any]]) -> str:
    return _counted(str(entry["source"]) for entry in entries)


def _counted(values: Iterable[str]) -> str:
    counts = Counter(values)
    return ", ".join(f"{count} {value}" for value, count in sorted(counts.items()))


def _coverage(entries: Sequence[Mapping[str, Any]]) -> str:
    shares = np.array([entry["share"] for entry in entries])
    return f"{shares.mean():.0%} ({shares.min():.0%} to {shares.max():.0%})"


def _check_up_with_sky(scene: Scene, masks: Path, findings: Findings) -> None:
    """Sky must lie higher than the rest, by the cameras' own word."""
    below = []
    for view in scene.views:
        both = findings.attempt(partial(load_masks, masks, view))
        if both is None or not both[1].any() or both[1].all():
            continue
        rays = torch.nn.functional.normalize(pixel_rays(view.camera), dim=-1)
        up = view.camera.cam_from_world[:3, :3].float() @ torch.tensor(UP)
        height = (rays @ up).numpy()
        if height[both[1]].mean() < height[~both[1]].mean():
            below.append(view.name)
    if len(below) > len(scene.views) / 2:
        findings.problems.append(
            f"{masks}: in {len(below)} of {len(scene.views)} photos the sky lies below the rest: "
            "the up direction is upside down or the sky masks are inverted; look at both pictures"
        )


def describe_up(scene: Scene, findings: Findings) -> None:
    """How level the photos are under the scene's up direction (-y)."""
    rotations = np.stack([view.camera.cam_from_world[:3, :3].numpy() for view in scene.views])
    rolls = np.abs(roll_deg(rotations, np.array(UP)))
    median = float(np.median(rolls))
    findings.facts["up"] = (
        f"photos lean by {median:.1f} degrees (median) and {rolls.max():.1f} (most) against it"
    )
    if median > _DOUBTFUL_ROLL_DEG:
        findings.warnings.append(
            f"half of the photos lean by more than {median:.0f} degrees: either they were taken so "
            "or the up direction is wrong; look at the picture"
        )


def describe_lighting(scene: Scene, folder: Path, findings: Findings) -> None:
    """Environment maps and evaluation masks of the test views, or that there are none."""
    test = scene.split("test")
    if not test:
        findings.facts["environment maps"] = "no test views; the evaluation shows training views"
        return
    lit = [view for view in test if view.evaluation is not None]
    if not lit:
        held_out = listed([view.name for view in test])
        findings.facts["environment maps"] = f"none; half-image scores what is held out: {held_out}"
        return
    found = 0
    for view in lit:
        if findings.attempt(partial(_usable, view, folder)):
            found += 1
    findings.facts["environment maps"] = f"found for {found} of {len(test)} test views"
    if unlit := [view.name for view in test if view.evaluation is None]:
        findings.warnings.append(
            f"no environment map for the test views {listed(unlit)}: they are not in the nerf-osr "
            "protocol"
        )


def _usable(view: View, folder: Path) -> bool:
    assert view.evaluation is not None  # only such views are asked for
    read_env_map(folder / view.evaluation.env_map)
    published_turn_rad(view, view.evaluation)
    if not scored_pixels(folder, view).any():
        raise InputError(
            f"{folder / (view.evaluation.mask or '')}: the evaluation mask of {view.name} is all "
            f"black once eroded by {EROSION_PX}x{EROSION_PX} px, so no pixel would be scored; "
            "white must mean evaluate"
        )
    return True
