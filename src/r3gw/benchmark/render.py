"""Mitsuba scenes: photos lit by an environment map, and ground truth at pixel centres.

Rendering runs on one thread: film blocks overlap by the reconstruction filter, and their sum must
not depend on the order in which threads finish. Importing this module selects Mitsuba's variant
`scalar_rgb`, the one that needs no LLVM.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan, degrees
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from r3gw.benchmark.cameras import WORLD_FROM_BUILDING
from r3gw.benchmark.materials import Kind, Material, bsdf
from r3gw.benchmark.meshes import Part, join
from r3gw.geometry.cameras import Camera

mi.set_variant("scalar_rgb")

Image = NDArray[np.float32]

MAX_DEPTH = 4  # Sun or sky, then two bounces
SUBPIXELS = 2  # Per side, for the mean albedo of a pixel


@dataclass(frozen=True)
class Truth:
    """What is seen at each pixel of one view, without passers-by.

    Attributes:
        albedo: ``[H, W, 3]`` diffuse reflectance, mean over the pixel's surface; 0 at sky.
        normal: ``[H, W, 3]`` world unit normal of the side seen at the pixel centre; 0 at sky.
        depth: ``[H, W]`` camera z at the pixel centre; 0 at sky.
        kind: ``[H, W]`` index into `KINDS`, -1 at sky.
    """

    albedo: Image
    normal: Image
    depth: Image
    kind: NDArray[np.int64]


KINDS = tuple(Kind)


def use_one_thread() -> None:
    """Make Mitsuba quiet and render on one thread from here on."""
    mi.set_log_level(mi.LogLevel.Error)
    dr.set_thread_count(1)


def shapes(parts: Sequence[Part], materials: dict[str, Material]) -> dict[str, mi.Mesh]:
    """One world-space mesh per material, in the order of first use."""
    groups: dict[str, list[Any]] = {}
    for name, mesh in parts:
        groups.setdefault(name, []).append(mesh)
    return {name: _shape(name, join(group), materials[name]) for name, group in groups.items()}


def _shape(name: str, mesh: Any, material: Material) -> mi.Mesh:
    properties = mi.Properties()
    properties["mesh_bsdf"] = mi.load_dict(bsdf(material), parallel=False, optimize=False)
    shape = mi.Mesh(
        name,
        len(mesh.vertices),
        len(mesh.faces),
        has_vertex_normals=True,
        has_vertex_texcoords=True,
        props=properties,
    )
    values = mi.traverse(shape)
    values["vertex_positions"] = (mesh.vertices @ WORLD_FROM_BUILDING.T).astype(np.float32).ravel()
    values["vertex_normals"] = (mesh.normals @ WORLD_FROM_BUILDING.T).astype(np.float32).ravel()
    values["vertex_texcoords"] = mesh.uvs.astype(np.float32).ravel()
    values["faces"] = mesh.faces.astype(np.uint32).ravel()
    values.update()
    return shape


def emitter(light: NDArray[np.float64]) -> mi.Emitter:
    """Mitsuba's environment light from a map ``[H, 2H, 3]`` in this project's convention.

    Mitsuba puts the first and last row at the poles, so the map is resampled to 2H + 1 rows, on
    which every one of its rows lies: bilinear lookup in both agrees exactly. Half a turn about z
    takes Mitsuba's axes to ours.
    """
    between = (light[:-1] + light[1:]) / 2
    rows = np.empty((2 * len(light) + 1, *light.shape[1:]))
    rows[1::2], rows[2:-1:2] = light, between
    rows[0], rows[-1] = light[0], light[-1]
    description = {
        "type": "envmap",
        "bitmap": mi.Bitmap(rows.astype(np.float32)),
        "to_world": mi.ScalarTransform4f().rotate([0, 0, 1], 180),
        "mis_compensation": True,
    }
    light_source: mi.Emitter = mi.load_dict(description)
    return light_source


def scene(light: mi.Emitter, solids: dict[str, mi.Mesh]) -> mi.Scene:
    """Put shapes under a light; shapes keep their order."""
    content: dict[str, Any] = {"type": "scene", "light": light}
    content |= {f"solid_{i:03d}": solid for i, solid in enumerate(solids.values())}
    lit: mi.Scene = mi.load_dict(content, parallel=False, optimize=False)
    return lit


def sensor(camera: Camera, sampler: dict[str, Any], reconstruction: str) -> mi.Sensor:
    """Mitsuba's sensor of a camera; Mitsuba's camera axes are left, up, forward."""
    world_from_cam = np.linalg.inv(camera.cam_from_world.numpy())
    world_from_cam[:, :2] *= -1.0
    fx, _, cx, cy = camera.intrinsics
    width, height = camera.width, camera.height
    view: mi.Sensor = mi.load_dict(
        {
            "type": "perspective",
            "fov": 2 * degrees(atan(width / (2 * fx))),
            "fov_axis": "x",
            "principal_point_offset_x": 0.5 - cx / width,
            "principal_point_offset_y": 0.5 - cy / height,
            "near_clip": 0.01,
            "far_clip": 1000.0,
            "to_world": mi.ScalarTransform4f(world_from_cam),
            "film": {
                "type": "hdrfilm",
                "width": width,
                "height": height,
                "pixel_format": "rgb",
                "component_format": "float32",
                "rfilter": {"type": reconstruction},
            },
            "sampler": sampler,
        }
    )
    return view


def photo(place: mi.Scene, camera: Camera, samples: int, seed: int) -> Image:
    """Path-traced linear radiance ``[H, W, 3]``."""
    view = sensor(camera, {"type": "multijitter", "sample_count": samples}, "gaussian")
    integrator = mi.load_dict({"type": "path", "max_depth": MAX_DEPTH, "rr_depth": 100})
    image = mi.render(place, sensor=view, integrator=integrator, spp=samples, seed=mi.UInt32(seed))
    return np.maximum(np.asarray(image, dtype=np.float32), 0.0)


def truth(place: mi.Scene, camera: Camera, kinds: Sequence[Kind]) -> Truth:
    """Geometry at pixel centres and mean albedo.

    Args:
        place: Scene without passers-by.
        camera: The view.
        kinds: Kind of each shape, in the scene's order.
    """
    names = "position:position,normal:sh_normal,face:geo_normal,shape:shape_index"
    seen = _variables(place, camera, names).astype(np.float64)
    position, normal, number = seen[..., :3], seen[..., 3:6], seen[..., 9].astype(np.int64)
    pose = camera.cam_from_world.numpy()
    is_solid = number > 0  # Mitsuba counts shapes from 1 here; 0 is the sky
    depth = np.where(is_solid, position @ pose[2, :3] + pose[2, 3], 0.0)
    towards = camera.centre.numpy() - position
    is_back = (seen[..., 6:9] * towards).sum(-1, keepdims=True) < 0
    normal = np.where(is_back, -normal, normal)
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    normal = normal / np.where(length > 0, length, 1.0)
    kind = np.array([-1, *(KINDS.index(kind) for kind in kinds)])[number]
    albedo = np.where(is_solid[..., None], _mean_albedo(place, camera), 0.0)
    return Truth(
        albedo.astype(np.float32), normal.astype(np.float32), depth.astype(np.float32), kind
    )


def touches(
    place: mi.Scene, camera: Camera, kinds: Sequence[Kind], wanted: Kind
) -> NDArray[np.bool_]:
    """Pixels ``[H, W]`` in which any part shows a shape of the wanted kind."""
    width, height = camera.width, camera.height
    fine = camera.scaled(SUBPIXELS * width, SUBPIXELS * height)
    number = _variables(place, fine, "shape:shape_index")[..., 0].astype(np.int64)
    hits = np.array([False, *(kind is wanted for kind in kinds)])[number]
    return np.asarray(hits.reshape(height, SUBPIXELS, width, SUBPIXELS).any(axis=(1, 3)))


def _mean_albedo(place: mi.Scene, camera: Camera) -> Image:
    """Albedo averaged over the part of each pixel that a surface covers."""
    width, height = camera.width, camera.height
    fine = camera.scaled(SUBPIXELS * width, SUBPIXELS * height)
    seen = _variables(place, fine, "albedo:albedo,shape:shape_index")
    seen = seen.reshape(height, SUBPIXELS, width, SUBPIXELS, 4)
    is_solid = seen[..., 3:] > 0
    covered = np.maximum(is_solid.sum(axis=(1, 3)), 1)
    total = (np.clip(seen[..., :3], 0.0, 1.0) * is_solid).sum(axis=(1, 3))
    return np.asarray(total / covered, dtype=np.float32)


def _variables(place: mi.Scene, camera: Camera, names: str) -> Image:
    """Mitsuba's arbitrary output variables ``[H, W, C]`` at pixel centres."""
    integrator = mi.load_dict({"type": "aov", "aovs": names})
    centred = {"type": "stratified", "sample_count": 1, "jitter": False}
    image = mi.render(place, sensor=sensor(camera, centred, "box"), integrator=integrator, spp=1)
    return np.asarray(image, dtype=np.float32)
