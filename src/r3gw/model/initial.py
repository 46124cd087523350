"""Initial point sets: sparse points for the foreground, a sampled dome for the sky (Sec. 4.3)."""

from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError
from r3gw.files.npz import Array, read_npz, write_npz
from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.geometry.spherical import angles_from_direction, direction_from_angles
from r3gw.model.settings import SkySettings
from r3gw.model.sky import SkyDome, even_dome, sample_dome

BOX_QUANTILES = (0.02, 0.98)
RADIUS_QUANTILE = 0.99
AZIMUTH_MARGIN_RAD = 0.1
DOME_MARGIN = 2.0  # radius of a dome around cameras, of the distance of the farthest one
_ARRAYS = {
    "foreground": Array(np.float32, (None, 3)),
    "centre": Array(np.float32, (3,)),
    "radius": Array(np.float64, ()),
    "azimuth_rad": Array(np.float64, (2,)),
    "sky_angles": Array(np.float32, (None, 2)),
}


@dataclass(frozen=True)
class InitialPoints:
    """What training starts from.

    Attributes:
        foreground: ``[N, 3]`` world positions.
        dome: The sky's hemisphere.
        sky_angles: ``[M, 2]`` (theta, phi) in radians.
    """

    foreground: Float[Tensor, "n 3"]
    dome: SkyDome
    sky_angles: Float[Tensor, "m 2"]

    def sky_points(self) -> Float[Tensor, "m 3"]:
        """World positions of the initial sky points."""
        theta, phi = self.sky_angles.unbind(-1)
        return self.dome.centre + self.dome.radius * direction_from_angles(theta, phi)


def initial_points(
    xyz: Float[Tensor, "n 3"], cameras: list[Camera], settings: SkySettings, seed: int
) -> InitialPoints:
    """Fit the dome to the sparse points and fill it with sky points.

    Args:
        xyz: Sparse points, world.
        cameras: The training cameras; they bound the azimuth range.
        settings: Counts and the kind of azimuth range.
        seed: Seed of the sky points.

    Raises:
        InputError: If there are no points.
    """
    if len(xyz) == 0:
        raise InputError("the SfM model has no points; reconstruct it again with more photos")
    low, high = torch.quantile(xyz, torch.tensor(BOX_QUANTILES), dim=0)
    from_mean = (xyz - xyz.mean(dim=0)).norm(dim=-1)
    radius = float(torch.quantile(from_mean, RADIUS_QUANTILE).clamp_min(1e-3))
    if settings.around == "cameras":
        radius = max(radius, DOME_MARGIN * farthest(cameras, 0.5 * (low + high)))
    azimuth = (-pi, pi) if settings.azimuth_range == "full" else seen_azimuths(cameras)
    dome = SkyDome(0.5 * (low + high), radius, azimuth)
    wanted = round(settings.count_per_radius * radius)
    count = min(max(wanted, settings.min_count), settings.max_count)
    generator = torch.Generator().manual_seed(seed)
    angles = even_dome(dome, count) if settings.is_closed else sample_dome(dome, count, generator)
    return InitialPoints(xyz, dome, angles)


def farthest(cameras: list[Camera], centre: Float[Tensor, "3"]) -> float:
    """Distance of the camera that is farthest from ``centre``, world units."""
    return max(float((camera.centre.to(centre) - centre).norm()) for camera in cameras)


def seen_azimuths(cameras: list[Camera]) -> tuple[float, float]:
    """Smallest azimuth interval that all cameras' pictures cover, with a margin, in radians.

    The largest gap between the azimuths of border and centre pixels is what nobody sees. A gap
    of less than an eighth of a turn is not worth cutting out: then the circle is full.
    """
    seen = []
    for camera in cameras:
        rays = pixel_rays(camera)
        border = torch.cat([rays[0], rays[-1], rays[:, 0], rays[:, -1], rays[rays.shape[0] // 2]])
        world = border @ camera.cam_from_world[:3, :3].float()
        seen.append(angles_from_direction(world)[1])
    azimuths = torch.cat(seen).sort().values
    gaps = torch.cat([azimuths[1:], azimuths[:1] + 2 * pi]) - azimuths
    widest = int(gaps.argmax())
    if float(gaps[widest]) < pi / 4:
        return -pi, pi
    last = float(azimuths[widest]) + AZIMUTH_MARGIN_RAD
    first = last + float(gaps[widest]) - 2 * AZIMUTH_MARGIN_RAD - 2 * pi
    return first, last


def save_initial(initial: InitialPoints, path: Path) -> None:
    """Write ``initial.npz`` atomically."""
    arrays = {
        "foreground": initial.foreground.numpy(),
        "centre": initial.dome.centre.numpy(),
        "radius": np.array(initial.dome.radius),
        "azimuth_rad": np.array(initial.dome.azimuth_rad),
        "sky_angles": initial.sky_angles.numpy(),
    }
    write_npz(path, arrays)


def load_initial(path: Path) -> InitialPoints:
    """Read ``initial.npz``.

    Raises:
        InputError: If it is missing, damaged, or holds something else.
    """
    arrays = read_npz(path, _ARRAYS, "run the initialise stage again")
    first, last = arrays["azimuth_rad"].tolist()
    dome = SkyDome(torch.from_numpy(arrays["centre"]), float(arrays["radius"]), (first, last))
    return InitialPoints(
        torch.from_numpy(arrays["foreground"]), dome, torch.from_numpy(arrays["sky_angles"])
    )
