"""How sharp and how right cast shadows are: PSNR within 3 px of true shadow outlines.

    python benchmarks/shadow_edges.py results [--picture shadows.jpg]

For every run of the embedded scenes below a results folder, test views of sunny sessions under the
true light, and training views under their learned ones; the outlines come from rays in the true
scenes. The picture shows a test view per scene: photo, true sun, and that of each run that casts
sharp shadows. Rows go to standard output as CSV.
"""

import argparse
import csv
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from r3gw.benchmark import render
from r3gw.benchmark.shooting import Studio
from r3gw.benchmark.sunlit import faces_sun, in_sun, shadow_edges
from r3gw.benchmark.work import PLACES
from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.evaluation.metrics import masked_psnr
from r3gw.imaging.files import read_linear, write_image
from r3gw.imaging.pictures import bytes_from_display
from r3gw.model.lights import photographed_light
from r3gw.model.model_file import load_model
from r3gw.rendering.compose import render as render_model
from r3gw.rendering.sun_shadow import shadow_in
from r3gw.scene import View, load_scene

SUNNY = 0.5  # Sessions with less cloud cover than this have shadows to speak of.
FEWEST_PIXELS = 100
COLUMNS = ("scene", "variant", "seed", "edge_exact", "edge_learned", "views_exact", "views_learned")


@dataclass(frozen=True)
class Truth:
    """What is known of the sun in one view.

    Attributes:
        reached: ``[H, W]`` pixels in the sun.
        edges: ``[H, W]`` pixels near the outline of a cast shadow.
    """

    reached: NDArray[np.bool_]
    edges: NDArray[np.bool_]


def truths(folder: Path, facts: dict[str, Any]) -> dict[str, Truth]:
    """Of all views of sunny sessions of a scene, by name."""
    made = facts["made_with"]
    studio = Studio(PLACES[made["scene"]], made["seed"], 1, is_denoised=False)
    place = studio.lit(render.emitter(np.ones((8, 16, 3))))
    found = {}
    for view in load_scene(folder / "scene").views:
        session = facts["sessions"][view.session]
        if view.truth is None or session["overcast"] >= SUNNY:
            continue
        sun = np.array(session["sun_direction"])
        depth, normal = (
            read_linear(folder / "scene" / path).astype(np.float64)
            for path in (view.truth.depth, view.truth.normal)
        )
        reached = in_sun(place, view.camera, depth[..., 0], normal, sun)
        found[view.name] = Truth(reached, shadow_edges(reached, faces_sun(normal, sun)))
    return found


def edge_psnr(evaluated: EvaluatedScene, known: dict[str, Truth], split: str) -> tuple[float, int]:
    """Mean over views of a split; and over how many."""
    found = []
    for view in evaluated.scene.split("test" if split == "test" else "train"):
        if view.name not in known or view.truth is None:
            continue
        if split == "test":
            light, counts = evaluated.true_light(view.truth), evaluated.is_scored(view)
        else:
            light = photographed_light(evaluated.model, view.name)
            counts = evaluated.masks(view)[0]
        where = known[view.name].edges & counts
        if where.sum() < FEWEST_PIXELS:
            continue
        picture = evaluated.render(view, light)
        found.append(masked_psnr(picture, evaluated.photo(view), where, view.name))
    return (float(np.mean(found)), len(found)) if found else (float("nan"), 0)


@torch.no_grad()
def seen_sun(evaluated: EvaluatedScene, view: View) -> NDArray[np.float64] | None:
    """Share of the sun in each pixel under the true light; None without sharp shadows."""
    assert view.truth is not None  # the caller's choice
    light = evaluated.true_light(view.truth)
    model, sun = evaluated.model, light.point
    if sun is None or not model.description.has_point_sun:
        return None
    depth = render_model(model, view.camera, light.sh, None).depth
    is_covered = torch.ones_like(depth, dtype=torch.bool)
    shadow = shadow_in(model, sun.direction)
    shown: NDArray[np.float64] = shadow.seen_from(view.camera, depth, is_covered).double().numpy()
    return shown


def runs(results: Path) -> Iterator[tuple[Path, Path]]:
    """Folders of a scene and of each of its runs."""
    for model in sorted(results.glob("*/*/seed*/model.safetensors")):
        yield model.parents[2], model.parent


def main() -> None:
    """Print a row per run, and write the picture if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path)
    parser.add_argument("--picture", type=Path)
    asked = parser.parse_args()
    torch.set_num_threads(1)
    table = csv.DictWriter(sys.stdout, COLUMNS)
    table.writeheader()
    rows: dict[Path, list[NDArray[np.float64]]] = {}

    @lru_cache(maxsize=1)
    def known(folder: Path) -> dict[str, Truth]:
        facts = json.loads((folder / "source/ground_truth/ground_truth.json").read_text())
        return truths(folder, facts)

    for folder, run in runs(asked.results):
        model, scene = load_model(run / "model.safetensors"), load_scene(folder / "scene")
        evaluated = EvaluatedScene(model, scene, folder / "scene", folder / "masks")
        exact, learned = (edge_psnr(evaluated, known(folder), each) for each in ("test", "train"))
        names = {"scene": folder.name, "variant": run.parent.name, "seed": run.name[4:]}
        figures = {"edge_exact": f"{exact[0]:.2f}", "edge_learned": f"{learned[0]:.2f}"}
        counts = {"views_exact": exact[1], "views_learned": learned[1]}
        table.writerow(names | figures | counts)
        view = max(
            (view for view in scene.split("test") if view.name in known(folder)),
            key=lambda view: int(known(folder)[view.name].edges.sum()),
        )
        shown = seen_sun(evaluated, view)
        if shown is not None:
            truth = known(folder)[view.name].reached.astype(np.float64)
            first = [evaluated.photo(view), np.repeat(truth[..., None], 3, axis=2)]
            rows.setdefault(folder, first).append(np.repeat(shown[..., None], 3, axis=2))
    if asked.picture is not None and rows:
        widest = max(len(row) for row in rows.values())
        full = [np.concatenate(row, axis=1) for row in rows.values() if len(row) == widest]
        write_image(asked.picture, bytes_from_display(torch.from_numpy(np.concatenate(full))))


if __name__ == "__main__":
    main()
