"""The sky that is seen is the light that is used: all that cameras see adds up to the SH light."""

from math import pi

import numpy as np
import pytest
import torch
from support.blob import blob_gaussians

from r3gw.geometry.cameras import Camera, pixel_directions
from r3gw.imaging.files import write_exr, write_image
from r3gw.lighting import envmap, sh
from r3gw.lighting.light import Light
from r3gw.lighting.sun import SUN_RADIUS_DEG
from r3gw.model.occlusion import upper_directions
from r3gw.relight.gaussians import Relightable
from r3gw.relight.lights import LightOptions, MapSource, SunSource, light_over_time
from r3gw.relight.picture import frame, sky_values
from r3gw.relight.sweep import Sweep
from r3gw.relight.tone import linear_from_scene, scene_linear

FACE_PX = 48
FACES = (
    ((0, 0, 1), (1, 0, 0)),
    ((0, 0, -1), (-1, 0, 0)),
    ((1, 0, 0), (0, 0, -1)),
    ((-1, 0, 0), (0, 0, 1)),
    ((0, 1, 0), (1, 0, 0)),
    ((0, -1, 0), (1, 0, 0)),
)


def cube() -> list[Camera]:
    """Six cameras at the origin that together see everything once."""
    cameras = []
    for forward, right in FACES:
        ahead, aside = (torch.tensor(each, dtype=torch.float64) for each in (forward, right))
        pose = torch.eye(4, dtype=torch.float64)
        pose[:3, :3] = torch.stack([aside, torch.linalg.cross(ahead, aside), ahead])
        half = FACE_PX / 2
        cameras.append(Camera(pose, (half, half, half, half), FACE_PX, FACE_PX))
    return cameras


def nothing_before_the_sky() -> Relightable:
    """A scene of one Gaussian that cannot be seen."""
    blob = blob_gaussians()
    return Relightable(
        blob.means[:1],
        blob.quaternions[:1],
        blob.log_scales[:1],
        torch.tensor([-30.0]),
        blob.albedo[:1],
        blob.roughness[:1],
        blob.lights,
        4,
        True,
    )


def light_of_what_is_seen(gaussians: Relightable, light: Light) -> torch.Tensor:
    """SH coefficients of all that six cameras see, by solid angles of their pixels."""
    total = torch.zeros(25, 3, dtype=torch.float64)
    for camera in cube():
        shown = linear_from_scene(frame(gaussians, camera, light, scene_linear)).double()
        looks = pixel_directions(camera).double()
        cosine = looks @ camera.cam_from_world[2, :3]
        solid_angle = (2 / FACE_PX) ** 2 * cosine**3
        total += torch.einsum("hwk,hwc->kc", sh.basis(looks, 4) * solid_angle[..., None], shown)
    return total.float()


def clouded_map(height: int) -> torch.Tensor:
    """Coloured clouds, ground, and a sun as wide as a phone's glare."""
    looks = envmap.pixel_directions(height, 2 * height).float()
    waves = torch.stack([(3 * looks @ torch.tensor(v)).sin() for v in _WAVES], dim=-1)
    sun = torch.nn.functional.normalize(torch.tensor([0.5, -0.6, 0.4]), dim=0)
    glare = 20 * torch.exp((looks @ sun - 1) / (1 - np.cos(np.radians(SUN_RADIUS_DEG / 2))))
    return 0.6 + 0.4 * waves + glare[..., None] * torch.tensor([1.0, 0.9, 0.7])


_WAVES = ([1.0, 0.3, 0.2], [0.1, -1.0, 0.5], [-0.4, 0.6, 0.9])


def written(kind: str, folder) -> LightOptions:
    """A map's file, turned and exposed; or the sun."""
    turn, exposure = Sweep((70.0,)), 0.6
    if kind == "sun":
        source: MapSource | SunSource = SunSource(Sweep((35.0,)), Sweep((140.0,)))
    elif kind == "exr":
        write_exr(folder / "map.exr", clouded_map(64).numpy())
        source = MapSource(folder / "map.exr")
    else:
        display = (0.25 * clouded_map(64)).clamp(0, 1)
        write_image(folder / "map.png", (255 * display).round().byte().numpy())
        source = MapSource(folder / "map.png")
    return LightOptions(source, turn, exposure, "map")


@pytest.mark.parametrize("kind", ["exr", "png", "sun"])
def test_pixels_of_the_sky_add_up_to_the_light(tmp_path, kind):
    gaussians = nothing_before_the_sky()
    light = light_over_time(gaussians, written(kind, tmp_path))(0.0)
    found = light_of_what_is_seen(gaussians, light)
    # The sun of a clear day is four pixels of its map, which a picture's pixels hit or miss.
    allowed = 0.15 if kind == "sun" else 0.01
    off = float((found - light.sh).norm() / light.sh.norm())
    assert off < allowed
    assert float((found[0] / light.sh[0] - 1).abs().max()) < allowed


@pytest.mark.parametrize("kind", ["exr", "png"])
def test_gaussians_of_the_sky_add_up_to_the_light_from_above(tmp_path, kind):
    """On a dome around the camera, as exports colour them."""
    light = light_over_time(blob_gaussians(), written(kind, tmp_path))(0.0)
    looks, blob = upper_directions(4000), blob_gaussians()
    dome = Relightable(
        torch.cat([blob.means[:1], 50 * looks]),
        blob.quaternions[:1].repeat(4001, 1),
        blob.log_scales[:1].repeat(4001, 1),
        torch.zeros(4001),
        blob.albedo[:1],
        blob.roughness[:1],
        blob.lights,
        4,
        True,
    )
    shown = linear_from_scene(sky_values(dome, torch.zeros(3).double(), light, scene_linear))
    found = sh.basis(looks, 4).T @ shown * (2 * pi / len(looks))
    assert light.sky is not None
    fine = envmap.pixel_directions(128, 256).float()
    above = torch.where(fine[..., 1:2] < 0, light.sky.radiance(fine), 0.0)
    expected = envmap.project(above, fine.double(), 4)
    assert float((found - expected).norm() / expected.norm()) < 0.01
    whole = envmap.project(light.sky.radiance(fine), fine.double(), 4)
    assert float((whole - light.sh).norm() / light.sh.norm()) < 0.01
