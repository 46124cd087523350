"""How well a scene was taken apart: albedo, normals, depth, light, sky.

Albedo and light are only known up to one factor per channel for the whole scene (a darker wall
under a stronger light gives the same photos), so that factor is fitted over the scene before
they are compared. Depth and normals are compared as they are.
"""

import cv2
import numpy as np
import torch
from jaxtyping import Bool, Float

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.evaluation.metrics import masked_psnr
from r3gw.geometry.cameras import Camera
from r3gw.imaging.files import read_linear
from r3gw.model.lights import photographed_light
from r3gw.rendering.surfaces import Surfaces, surfaces_of
from r3gw.scene import View

BAND_PX = 5.0
CHANNELS = "rgb"
DIFFUSE_COEFFICIENTS = 9

Record = dict[str, str | float]


def scale_per_channel(
    values: Float[np.ndarray, "n 3"], truth: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "3"]:
    """Least-squares factors that bring ``values`` to ``truth``; 0 where all values are 0."""
    power = (values**2).sum(axis=0)
    return np.asarray((values * truth).sum(axis=0) / np.where(power > 0, power, 1.0))


def angles_deg(
    normals: Float[np.ndarray, "n 3"], truth: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n"]:
    """Angles between unit vectors; a zero vector (no surface rendered) counts as 90 degrees."""
    return np.asarray(np.degrees(np.arccos(np.clip((normals * truth).sum(axis=-1), -1.0, 1.0))))


def abs_rel(depth: Float[np.ndarray, "n"], truth: Float[np.ndarray, "n"]) -> float:
    """Mean of ``|depth - truth| / truth``, without alignment."""
    return float(np.mean(np.abs(depth - truth) / truth))


def sky_band(is_sky: Bool[np.ndarray, "h w"]) -> Bool[np.ndarray, "h w"]:
    """Pixels within 5 px of the sky's outline, on both of its sides (Euclidean distance)."""
    inside, outside = (
        cv2.distanceTransform(side.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        for side in (is_sky, ~is_sky)
    )
    return np.asarray((inside <= BAND_PX) & (outside <= BAND_PX)) & _has_outline(is_sky)


def _has_outline(is_sky: Bool[np.ndarray, "h w"]) -> bool:
    return bool(is_sky.any() and not is_sky.all())


def count_in_front(
    means: Float[torch.Tensor, "n 3"], camera: Camera, depth: Float[np.ndarray, "h w"]
) -> int:
    """How many points lie before the surface that the camera sees in their pixel.

    Args:
        means: World positions.
        camera: The view.
        depth: Camera z of the surfaces, 0 where there is none.
    """
    pose = camera.cam_from_world.numpy()
    points = means.double().numpy() @ pose[:3, :3].T + pose[:3, 3]
    points = points[points[:, 2] > 0]
    fx, fy, cx, cy = camera.intrinsics
    column = np.floor(points[:, 0] / points[:, 2] * fx + cx).astype(np.int64)
    row = np.floor(points[:, 1] / points[:, 2] * fy + cy).astype(np.int64)
    is_seen = (column >= 0) & (column < camera.width) & (row >= 0) & (row < camera.height)
    surface = depth[row[is_seen], column[is_seen]]
    return int((points[is_seen, 2] < surface).sum())


def surface_records(evaluated: EvaluatedScene) -> list[Record]:
    """Albedo, normals and depth of the test views with ground truth, over their masks.

    Per view: ``albedo_psnr_{r,g,b}`` and their mean ``albedo_psnr`` (dB, linear albedo),
    ``normal_mean_deg``, ``normal_median_deg``, ``depth_abs_rel``. Views whose mask shows no
    surface are left out.
    """
    compared = []
    for view in evaluated.scene.split("test"):
        if view.truth is None:
            continue
        truth = {
            kind: read_linear(evaluated.scene_folder / getattr(view.truth, kind)).astype(np.float64)
            for kind in ("albedo", "normal", "depth")
        }
        where = evaluated.is_scored(view) & (truth["depth"][..., 0] > 0)
        if where.any():
            compared.append((view, truth, surfaces_of(evaluated.model, view.camera), where))
    if not compared:
        return []
    scale = scale_per_channel(
        np.concatenate([ours.albedo[where] for _, _, ours, where in compared]),
        np.concatenate([truth["albedo"][where] for _, truth, _, where in compared]),
    )
    return [_surface_record(*each, scale) for each in compared]


def _surface_record(
    view: View,
    truth: dict[str, Float[np.ndarray, "h w 3"]],
    ours: Surfaces,
    where: Bool[np.ndarray, "h w"],
    scale: Float[np.ndarray, "3"],
) -> Record:
    albedo = ours.albedo * scale
    psnr = [
        masked_psnr(albedo[..., c : c + 1], truth["albedo"][..., c : c + 1], where, view.name)
        for c in range(3)
    ]
    angles = angles_deg(ours.normal[where], truth["normal"][where])
    return {
        "view": view.name,
        **{f"albedo_psnr_{c}": value for c, value in zip(CHANNELS, psnr, strict=True)},
        "albedo_psnr": float(np.mean(psnr)),
        "normal_mean_deg": float(angles.mean()),
        "normal_median_deg": float(np.median(angles)),
        "depth_abs_rel": abs_rel(ours.depth[where], truth["depth"][where][:, 0]),
    }


def light_records(evaluated: EvaluatedScene) -> list[Record]:
    """Learned lights of the training views with ground truth against the true ones.

    Per view: ``light_error``, the norm of the coefficients' difference over the norm of the true
    coefficients, after one factor per channel for the scene; ``light_error_diffuse`` the same
    over bands 0 to 2, which are all that diffuse surfaces show.
    """
    views = [view for view in evaluated.scene.split("train") if view.truth is not None]
    if not views:
        return []
    learned = np.stack(
        [_numpy(photographed_light(evaluated.model, view.name).sh) for view in views]
    )
    true = np.stack(
        [_numpy(evaluated.true_light(view.truth).sh) for view in views if view.truth is not None]
    )
    scale = scale_per_channel(learned.reshape(-1, 3), true.reshape(-1, 3))
    few = DIFFUSE_COEFFICIENTS
    return [
        {
            "view": view.name,
            "light_error": _relative_error(ours * scale, truth),
            "light_error_diffuse": _relative_error(ours[:few] * scale, truth[:few]),
        }
        for view, ours, truth in zip(views, learned, true, strict=True)
    ]


def _numpy(coefficients: torch.Tensor) -> Float[np.ndarray, "coeff 3"]:
    return coefficients.double().numpy()


def _relative_error(
    values: Float[np.ndarray, "coeff 3"], truth: Float[np.ndarray, "coeff 3"]
) -> float:
    return float(np.linalg.norm(values - truth) / np.linalg.norm(truth))


def sky_records(evaluated: EvaluatedScene) -> list[Record]:
    """How cleanly sky and foreground part, in every training view that shows a sky outline.

    Per view: ``sky_boundary_psnr`` under the learned light, over valid pixels within 5 px of the
    outline; ``sky_foreground_alpha``, the mean opacity of foreground on valid sky pixels; where
    the true depth is known, ``sky_in_front``, the count of sky Gaussians before a surface.
    """
    records = []
    for view in evaluated.scene.split("train"):
        is_valid, is_sky = evaluated.masks(view)
        band = sky_band(is_sky) & is_valid
        if not band.any() or not (is_sky & is_valid).any():
            continue
        picture = evaluated.render(view, photographed_light(evaluated.model, view.name))
        alpha = surfaces_of(evaluated.model, view.camera).foreground_alpha
        record: Record = {
            "view": view.name,
            "sky_boundary_psnr": masked_psnr(picture, evaluated.photo(view), band, view.name),
            "sky_foreground_alpha": float(alpha[is_sky & is_valid].mean()),
        }
        if view.truth is not None:
            depth = read_linear(evaluated.scene_folder / view.truth.depth)[..., 0]
            record["sky_in_front"] = float(
                count_in_front(evaluated.model.sky.means().detach(), view.camera, depth)
            )
        records.append(record)
    return records
