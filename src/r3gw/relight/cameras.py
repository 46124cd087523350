"""Cameras of a film: a photo's own, a smooth path through several, an orbit about the scene."""

from dataclasses import dataclass
from math import radians

import numpy as np
import torch
from jaxtyping import Float
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.spatial.transform import Rotation, RotationSpline
from torch import Tensor

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera, upright_pose
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.relight.sweep import Sweep
from r3gw.scene import Scene, View

# Weight of the prior in `focus`: it decides only where parallel cameras say nothing.
PRIOR_WEIGHT = 1e-3
MOST_NAMES = 12  # of views, in a message
SMALLEST_STEP = 1e-6  # between two photos from the same spot, in units of the path's length


@dataclass(frozen=True)
class CameraOptions:
    """The camera of a picture or a film.

    Attributes:
        views: Names of photos: one stands still, several make a smooth path.
        orbit_deg: Turn about the scene, from the one view, positive to its right.
        width_px: Width of the pictures; None keeps the (first) photo's.
    """

    views: tuple[str, ...]
    orbit_deg: Sweep | None = None
    width_px: int | None = None

    @property
    def moves(self) -> bool:
        """Whether frames have different cameras."""
        return len(self.views) > 1 or (self.orbit_deg is not None and self.orbit_deg.moves)


def cameras_over_time(
    scene: Scene, options: CameraOptions, middle: Float[Tensor, "3"], times: list[float]
) -> list[Camera]:
    """One camera for each of the times (0 to 1) of a film.

    Args:
        scene: Holds the views.
        options: How the camera stands or moves.
        middle: Middle of the scene's surfaces, the prior of `focus`.
        times: The times of the frames.

    Raises:
        InputError: If a view is unknown or none is given, or an orbit has not exactly one view.
    """
    if not options.views:
        raise InputError("pictures need the camera of at least one view")
    cameras = [view_named(scene, name).camera for name in options.views]
    if options.width_px is not None:
        height = max(1, round(cameras[0].height * options.width_px / cameras[0].width))
        cameras[0] = cameras[0].scaled(options.width_px, height)
    if options.orbit_deg is not None:
        if len(cameras) != 1:
            raise InputError(f"an orbit starts from one view, but {len(cameras)} are given")
        centre = focus([view.camera for view in scene.split("train")], middle)
        turns = [radians(options.orbit_deg.at(time)) for time in times]
        return [orbited(cameras[0], centre, turn) for turn in turns]
    if len(cameras) == 1:
        return cameras * len(times)
    return path(cameras, times)


def view_named(scene: Scene, name: str) -> View:
    """A view of the scene.

    Raises:
        InputError: If there is none of that name.
    """
    views = {view.name: view for view in scene.views}
    if name not in views:
        if (stem := name.rpartition(".")[0]) in views:
            raise InputError(
                f"scene '{scene.name}' has no view '{name}'; views have no suffix: give '{stem}'"
            )
        more = f" and {len(views) - MOST_NAMES} more" if len(views) > MOST_NAMES else ""
        known = ", ".join([*views][:MOST_NAMES])
        raise InputError(f"scene '{scene.name}' has no view '{name}'; it has: {known}{more}")
    return views[name]


def focus(cameras: list[Camera], prior: Float[Tensor, "3"]) -> Float[Tensor, "3"]:
    """The point nearest to all optical axes in least squares, float64.

    Args:
        cameras: At least one.
        prior: Weakly drawn to, so that parallel axes have an answer too.
    """
    weight = PRIOR_WEIGHT * len(cameras)
    left = weight * torch.eye(3, dtype=torch.float64)
    right = weight * prior.double()
    for camera in cameras:
        axis = camera.cam_from_world[2, :3]
        across = torch.eye(3, dtype=torch.float64) - torch.outer(axis, axis)
        left = left + across
        right = right + across @ camera.centre
    nearest: Tensor = torch.linalg.solve(left, right)
    return nearest


def orbited(camera: Camera, centre: Float[Tensor, "3"], turn_rad: float) -> Camera:
    """The camera carried about the vertical through ``centre``, and turned to look at it.

    Args:
        camera: Gives distance, height and intrinsics.
        centre: What stays at the principal point.
        turn_rad: Positive carries the camera to its right.
    """
    position = centre + rotation_about_axis(1, -turn_rad) @ (camera.centre - centre)
    pose = upright_pose(centre, position)
    return Camera(pose, camera.intrinsics, camera.width, camera.height)


def path(cameras: list[Camera], times: list[float]) -> list[Camera]:
    """A smooth path through cameras, in the first one's picture size.

    Positions follow a natural cubic spline and orientations a rotation spline, both over the
    square root of the distance (centripetal), so that the path does not overshoot. The vertical
    field of view and the principal point change monotonically in between.
    """
    centres = np.stack([camera.centre.numpy() for camera in cameras])
    steps = np.sqrt(np.linalg.norm(np.diff(centres, axis=0), axis=1))
    steps = np.maximum(steps, max(SMALLEST_STEP * float(steps.sum()), SMALLEST_STEP))
    knots = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    rotations = Rotation.from_matrix(np.stack([c.cam_from_world[:3, :3] for c in cameras]))
    lenses = PchipInterpolator(knots, np.stack([_lens(camera) for camera in cameras]))(times)
    positions = CubicSpline(knots, centres, bc_type="natural")(times)
    turns = RotationSpline(knots, rotations)(times).as_matrix()
    found = []
    for position, turn, lens in zip(positions, turns, lenses, strict=True):
        cam_from_world = torch.eye(4, dtype=torch.float64)
        cam_from_world[:3, :3] = torch.from_numpy(turn)
        cam_from_world[:3, 3] = torch.from_numpy(-turn @ position)
        found.append(_with_lens(cameras[0], cam_from_world, lens))
    return found


def _lens(camera: Camera) -> Float[np.ndarray, "4"]:
    """Log focal length, pixel aspect and principal point from the middle, in picture heights."""
    fx, fy, cx, cy = camera.intrinsics
    right, down = (cx - camera.width / 2) / camera.height, cy / camera.height - 0.5
    return np.array([np.log(fy / camera.height), fx / fy, right, down])


def _with_lens(
    frame: Camera, cam_from_world: Float[Tensor, "4 4"], lens: Float[np.ndarray, "4"]
) -> Camera:
    focal, aspect, right, down = (float(value) for value in lens)
    height = frame.height
    fy = float(np.exp(focal)) * height
    principal = (frame.width / 2 + right * height, (0.5 + down) * height)
    return Camera(cam_from_world, (fy * aspect, fy, *principal), frame.width, height)
