"""How much of the truth can be found again when geometry starts from it and the lights are known.

For every embedded scene, after `make all`: points are drawn from the true depth of the training
photos, and the settings of a variant are trained once with the lights that it learns and once with
the true lights held fixed. Prints albedo (scale-invariant PSNR) and normals (median error) over the
evaluated pixels, as they are and with detail of a few pixels blurred away, beside what the blurred
truth itself would reach; writes results/benchmarks/recovery.csv and a picture per scene.

    python benchmarks/recovery.py [--variant full --variant r3gw_plus] [--iterations 1000]
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click
import cv2
import numpy as np
import pandas as pd
import torch
from jaxtyping import Float

from r3gw.evaluation.decomposition import scale_per_channel, surface_records
from r3gw.evaluation.evaluated_scene import EvaluatedScene, true_light
from r3gw.evaluation.metrics import masked_psnr
from r3gw.files import atomic_path
from r3gw.files.strict import read_yaml
from r3gw.geometry.cameras import pixel_rays
from r3gw.imaging.colour import display_array_from_linear
from r3gw.imaging.files import read_linear, write_image
from r3gw.imaging.pictures import bytes_from_display, normal_picture
from r3gw.model.initial import InitialPoints, load_initial
from r3gw.model.light_models.fixed import FixedLight
from r3gw.pipeline.config import load_config, run_settings
from r3gw.rendering.surfaces import surfaces_of
from r3gw.scene import Scene, load_scene
from r3gw.training.loop import train
from r3gw.training.photos import load_photos
from r3gw.training.settings import TrainSettings
from r3gw.training.start import initial_model

ROOT = Path(__file__).parents[1]
TARGET = Path("results/benchmarks")
POINTS_PER_PHOTO = 600
BLUR_PX = 2.0  # Standard deviation: what is finer counts as detail.


def true_points(scene: Scene, folder: Path) -> Float[torch.Tensor, "n 3"]:
    """World points on the surfaces that the training photos show."""
    generator = torch.Generator().manual_seed(0)
    found = []
    for view in scene.split("train"):
        assert view.truth is not None  # embedded scenes have it
        depth = torch.from_numpy(read_linear(folder / view.truth.depth)[..., 0].copy())
        points = pixel_rays(view.camera) * depth[..., None]
        points = points[depth > 0]
        chosen = points[torch.randperm(len(points), generator=generator)[:POINTS_PER_PHOTO]]
        pose = view.camera.cam_from_world.float()
        found.append((chosen - pose[:3, 3]) @ pose[:3, :3])
    return torch.cat(found)


def trained(folder: Path, settings: TrainSettings, *, lights_known: bool) -> EvaluatedScene:
    """A model of one scene, started from its true points."""
    scene_folder, masks_folder = folder / "scene", folder / "masks"
    scene = load_scene(scene_folder)
    views = scene.split("train")
    photos = load_photos(scene, scene_folder, masks_folder)
    given = load_initial(folder / "initial.npz")
    points = InitialPoints(true_points(scene, scene_folder), given.dome, given.sky_angles)
    light_model = None
    if lights_known:
        degree, truths = settings.model.light_degree, [view.truth for view in views]
        lights = [true_light(scene_folder, truth, degree).sh for truth in truths if truth]
        light_model = FixedLight(torch.stack(lights))
    model = initial_model(
        points,
        tuple(photo.name for photo in photos),
        settings,
        tuple(view.session or view.name for view in views),
        [photo.seen_sky for photo in photos],
        light_model,
    )
    model = train(model, photos, settings).model
    return EvaluatedScene(model, scene, scene_folder, masks_folder)


@dataclass(frozen=True)
class Shown:
    """Surfaces of one test view over its mask: a model's, or the true ones."""

    albedo: np.ndarray
    normal: np.ndarray
    mask: np.ndarray

    def blurred(self) -> np.ndarray:
        """The albedo, blurred inside the mask, so that nothing from outside bleeds in."""
        weight = cv2.GaussianBlur(self.mask.astype(np.float64), (0, 0), BLUR_PX)
        inside = cv2.GaussianBlur(self.albedo * self.mask[..., None], (0, 0), BLUR_PX)
        return np.asarray(inside / np.maximum(weight, 1e-6)[..., None])


def shown(case: EvaluatedScene) -> Iterator[tuple[Shown, Shown]]:
    """Every test view as the model has it, and as it is."""
    for view in case.scene.split("test"):
        assert view.truth is not None  # embedded scenes have it
        truth = {
            kind: read_linear(case.scene_folder / getattr(view.truth, kind)).astype(np.float64)
            for kind in ("albedo", "normal", "depth")
        }
        mask = case.is_scored(view) & (truth["depth"][..., 0] > 0)
        ours = surfaces_of(case.model, view.camera)
        yield Shown(ours.albedo, ours.normal, mask), Shown(truth["albedo"], truth["normal"], mask)


def compared(case: EvaluatedScene) -> tuple[dict[str, float], np.ndarray]:
    """Figures over the test views, and a picture of the first: truth above, ours below."""
    records = surface_records(case)
    figures = {
        kind: float(np.mean([record[kind] for record in records]))
        for kind in ("albedo_psnr", "normal_median_deg")
    }
    views = list(shown(case))
    soft = [(ours.blurred(), truth.blurred(), truth.mask) for ours, truth in views]
    figures["albedo_psnr_blurred"] = _psnr(soft)
    detail = [(truth.blurred(), truth.albedo, truth.mask) for _, truth in views]
    figures["albedo_psnr_of_blurred_truth"] = _psnr(detail)
    ours, truth = views[0]
    scale = scale_per_channel(ours.albedo[ours.mask], truth.albedo[ours.mask])
    rows = [(truth.albedo, truth.normal), (ours.albedo * scale, ours.normal)]
    return figures, np.concatenate([_row(*row) for row in rows])


def _psnr(views: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> float:
    """Scale-invariant PSNR of albedo pictures: found, true, mask."""
    scale = scale_per_channel(
        np.concatenate([found[mask] for found, _, mask in views]),
        np.concatenate([true[mask] for _, true, mask in views]),
    )
    return float(np.mean([masked_psnr(found * scale, true, m, "") for found, true, m in views]))


def _row(albedo: np.ndarray, normal: np.ndarray) -> np.ndarray:
    display = bytes_from_display(display_array_from_linear(albedo))
    return np.concatenate([display, normal_picture(normal)], axis=1)


@click.command()
@click.option("--variant", "variants", multiple=True, default=("full", "r3gw_plus"))
@click.option("--iterations", type=int, help="Instead of the embedded run's.")
@click.option("--scene", "scenes", multiple=True, help="Instead of all.")
def main(variants: tuple[str, ...], iterations: int | None, scenes: tuple[str, ...]) -> None:
    """Print what is found again of albedo and normals, with learned and with true lights."""
    torch.set_num_threads(1)
    config = load_config(read_yaml(ROOT / "config/config.yaml"), "config/config.yaml")
    rows = []
    for scene in scenes or sorted(config.scenes):
        for variant in variants:
            files = {f"{kind}_file": ROOT / f"config/{kind}.yaml" for kind in ("train", "variants")}
            settings = run_settings(config, variant, 0, **files)
            if iterations:
                settings = settings.model_copy(update={"iterations": iterations})
            for lights_known in (False, True):
                case = trained(Path("results") / scene, settings, lights_known=lights_known)
                figures, picture = compared(case)
                lights = "true" if lights_known else "learned"
                rows.append({"scene": scene, "variant": variant, "lights": lights, **figures})
                write_image(TARGET / f"recovery_{scene}_{variant}_{lights}.png", picture)
                print(pd.DataFrame(rows).round(2).to_string(index=False))
    with atomic_path(TARGET / "recovery.csv") as path:
        pd.DataFrame(rows).to_csv(path, index=False, float_format="%.5g")


if __name__ == "__main__":
    main()
