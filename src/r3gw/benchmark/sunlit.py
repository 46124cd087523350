"""Which pixels of a view stand in the sun, and where its shadows end, by rays in the true scene.

Importing this module selects Mitsuba's variant, as `r3gw.benchmark.render` does.
"""

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.lighting.daylight import VARIANT

mi.set_variant(VARIANT)

OFFSET = 0.004  # of a ray's start from its surface, along the normal, in metres
LEAST_COSINE = 0.05  # of sun and normal: below, a surface counts as turned away
EDGE_PX = 3.0  # width of the band on both sides of a shadow's outline

Mask = NDArray[np.bool_]


def faces_sun(normal: NDArray[np.float64], sun: NDArray[np.float64]) -> Mask:
    """Pixels ``[H, W]`` whose surfaces are turned to the sun.

    Args:
        normal: ``[H, W, 3]`` true unit normals, 0 at sky.
        sun: Unit vector towards the sun.
    """
    return np.asarray(normal @ sun > LEAST_COSINE)


def in_sun(
    place: mi.Scene,
    camera: Camera,
    depth: NDArray[np.float64],
    normal: NDArray[np.float64],
    sun: NDArray[np.float64],
) -> Mask:
    """Pixels ``[H, W]`` whose centres show a surface that the sun reaches.

    Args:
        place: The true scene.
        camera: The view.
        depth: ``[H, W]`` true camera z, 0 at sky.
        normal: ``[H, W, 3]`` true unit normals of the sides seen.
        sun: Unit vector towards the sun, world axes.
    """
    pose = camera.cam_from_world.numpy()
    rays = pixel_rays(camera).numpy().astype(np.float64)
    points = (rays * depth[..., None] - pose[:3, 3]) @ pose[:3, :3] + OFFSET * normal
    towards = mi.Vector3f(*(float(value) for value in sun))
    reached = np.zeros(depth.shape, np.bool_)
    for row, column in zip(*np.nonzero((depth > 0) & (normal @ sun > 0)), strict=True):
        start = mi.Point3f(*(float(value) for value in points[row, column]))
        reached[row, column] = not place.ray_test(mi.Ray3f(start, towards))
    return reached


def shadow_edges(reached: Mask, is_facing: Mask) -> Mask:
    """Pixels within 3 px of the outline of a cast shadow.

    An outline lies between two neighbours that both face the sun, of which it reaches one. Where a
    surface turns away from the sun there is no cast shadow.

    Args:
        reached: `in_sun`.
        is_facing: `faces_sun`.
    """
    outline = np.zeros_like(reached)
    for first, second in (
        (np.s_[1:, :], np.s_[:-1, :]),
        (np.s_[:, 1:], np.s_[:, :-1]),
    ):
        differs = reached[first] != reached[second]
        ends = differs & is_facing[first] & is_facing[second]
        outline[first] |= ends
        outline[second] |= ends
    if not outline.any():
        return outline
    return np.asarray(ndimage.distance_transform_edt(~outline) <= EDGE_PX)
